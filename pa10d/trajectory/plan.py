"""A plan: motions one after another, each from rest to rest, and the moves between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.trajectory.limits import MotionLimits
from pa10d.trajectory.motions import (
    Drawing,
    Motion,
    MotionSamples,
    Narrowed,
    Slowed,
    motion_from_dict,
    move_time,
)
from pa10d.trajectory.poses import Surroundings
from pa10d.trajectory.ways import free_way

Array = NDArray[np.float64]

GENTLE = 0.5  # of speed and acceleration for moves that only lead somewhere
NEAR = 1e-9  # rad


@dataclass(frozen=True)
class Segment:
    """A motion and what it is for; ``label`` is empty for a move that only leads to the next.
    joint: the one that it is about, 1-based; 0: more than one."""

    motion: Motion
    label: str = ""
    joint: int = 0


@dataclass(frozen=True)
class Span:
    """s from the start of the plan: the part of a segment that an analysis looks at."""

    label: str
    begin: float
    end: float
    joint: int = 0


@dataclass(frozen=True)
class Plan:
    """kind: the experiment's; joints: those that it is about, 1-based; notes: what was decided on
    the way, in words; weightless: those of the joints on which gravity does not act meanwhile."""

    kind: str
    joints: tuple[int, ...]
    segments: tuple[Segment, ...]
    notes: tuple[str, ...] = ()
    weightless: tuple[int, ...] = ()

    @property
    def n(self) -> int:
        """Number of joints of the arm."""
        return self.segments[0].motion.n

    @property
    def duration(self) -> float:
        """s."""
        return sum(s.motion.duration for s in self.segments)

    @property
    def start(self) -> Array:
        """(n,) pose at which the arm must stand."""
        return self.segments[0].motion.start

    @property
    def spans(self) -> tuple[Span, ...]:
        """What to look at, in order."""
        found, begin = [], 0.0
        for segment in self.segments:
            first, last = segment.motion.steady
            if segment.label:
                found.append(Span(segment.label, begin + first, begin + last, segment.joint))
            begin += segment.motion.duration
        return tuple(found)

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """q, dq, ddq (N, n) at times t (N,) s."""
        ends = np.cumsum([s.motion.duration for s in self.segments])
        which = np.minimum(np.searchsorted(ends, t, side="right"), len(self.segments) - 1)
        q, dq, ddq = np.empty((3, len(t), self.n))
        for k, segment in enumerate(self.segments):
            rows = which == k
            if rows.any():
                begin = ends[k] - segment.motion.duration
                inside = np.clip(t[rows] - begin, 0.0, segment.motion.duration)
                q[rows], dq[rows], ddq[rows] = segment.motion.at(inside)
        return q, dq, ddq

    def slowed(self, factor: float) -> Plan:
        """The same way at a slower pace."""
        segments = tuple(
            Segment(Slowed(s.motion.to_dict(), factor), s.label, s.joint) for s in self.segments
        )
        return replace(self, segments=segments)

    def narrowed(self, share: Array, about: Array) -> Plan:
        """Joints turn only a share (n,) as far away from ``about`` (n,) rad, in the same time."""
        segments = tuple(
            Segment(Narrowed(s.motion.to_dict(), share, about), s.label, s.joint)
            for s in self.segments
        )
        return replace(self, segments=segments)

    def sample(self, rate: float) -> MotionSamples:
        """The whole plan at ``rate`` Hz; the last sample is at rest."""
        t = np.arange(int(np.ceil(self.duration * rate - 1e-9)) + 1) / rate
        return MotionSamples(t, *self.at(t))

    def to_dict(self) -> JsonObject:
        """Every motion in numbers, for a file."""
        return {
            "kind": self.kind,
            "joints": list(self.joints),
            "notes": list(self.notes),
            "weightless": list(self.weightless),
            "segments": [
                {"label": s.label, "joint": s.joint, **s.motion.to_dict()} for s in self.segments
            ],
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Plan:
        """The reverse of ``to_dict``."""
        try:
            segments = [dict(entry) for entry in data["segments"]]
            about = [(str(e.pop("label", "")), int(e.pop("joint", 0))) for e in segments]
            weightless = tuple(int(j) for j in data.get("weightless", ()))
            motions = [motion_from_dict(entry) for entry in segments]
            head = (str(data["kind"]), tuple(int(j) for j in data["joints"]))
        except (KeyError, TypeError, ValueError) as error:
            raise UserError(
                f"plan: {error}; expected kind, joints and a list of segments"
            ) from error
        parts = tuple(Segment(m, *told) for m, told in zip(motions, about, strict=True))
        return cls(*head, parts, tuple(str(note) for note in data.get("notes", ())), weightless)


def joined(
    kind: str,
    joints: Sequence[int],
    segments: Sequence[Segment],
    around: Surroundings,
    notes: Sequence[str] = (),
) -> Plan:
    """A plan whose segments follow each other: gentle moves are put where poses differ, on ways
    that meet nothing.

    joints: 0-based here, as everywhere inside.
    """
    parts: list[Segment] = []
    for segment in segments:
        if parts:
            here, there = parts[-1].motion.end, segment.motion.start
            for point in free_way(around, here, there):
                parts.append(Segment(move(here, point, around.limits)))
                here = point
        parts.append(segment)
    return Plan(kind, tuple(int(j) + 1 for j in joints), tuple(parts), tuple(notes))


def move(start: Array, end: Array, limits: MotionLimits, gentle: float = GENTLE) -> Motion:
    """From rest to rest, all joints in the same time."""
    drawing = Drawing(start)
    span = np.asarray(end) - start
    needed = move_time(span, gentle * limits.velocity, gentle * limits.acceleration)
    drawing.to(end, max(needed, 0.1))
    return drawing.knots()
