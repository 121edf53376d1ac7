"""How near a planned motion comes to what it must not reach, before anything moves.

The numbers are those of the pre-check: the same bodies, the same braking distance, the same torque.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.experiments.motion import Whole
from pa10d.trajectory.capsules import Capsules
from pa10d.trajectory.limits import MotionLimits

Array = NDArray[np.float64]

POSES = 600  # of a motion that are sent to be looked at
DIGITS = 4  # of a pose's angles: 0.1 mrad


@dataclass(frozen=True)
class JointMargin:
    """position: rad (m) left to the nearer limit, braking included, and ``at`` which second; of the
    other limits the shares that are used, None where there is none. joint: from 1."""

    joint: int
    position: float
    at: float
    velocity: float | None
    acceleration: float | None
    torque: float | None


@dataclass(frozen=True)
class Gap:
    """The smallest between bodies. margin: m; at: s; between: which."""

    margin: float
    at: float
    between: str


@dataclass(frozen=True)
class Margins:
    """own: between the arm's bodies; floor: above it; boxes: to them; None where there is nothing
    that could be met."""

    joints: list[JointMargin]
    own: Gap | None
    floor: Gap | None
    boxes: Gap | None

    def document(self) -> JsonObject:
        """As JSON, where the arm's own gap is called ``self``."""
        told = asdict(self)
        return {"joints": told.pop("joints"), "self": told.pop("own"), **told}


@dataclass(frozen=True)
class Poses:
    """Of a motion, at equal steps of ``dt`` s, few enough to be sent. begins, ends: s of the plan
    itself, without the way to it; seconds: of all of it."""

    dt: float
    poses: list[list[float]]
    begins: float
    ends: float
    seconds: float


def margins(whole: Whole, torque: Array, limits: MotionLimits, bodies: Capsules) -> Margins:
    """Of a motion that needs ``torque``, (N, n) N·m."""
    t, q, dq, ddq = whole.samples
    stop = q + dq * np.abs(dq) / (2 * limits.acceleration)
    left = np.minimum(limits.upper - stop, stop - limits.lower)
    at = np.argmin(left, axis=0)
    joints = [
        JointMargin(
            joint=j + 1,
            position=float(left[at[j], j]),
            at=float(t[at[j]]),
            velocity=_share(dq[:, j], limits.velocity[j]),
            acceleration=_share(ddq[:, j], limits.acceleration[j]),
            torque=_share(torque[:, j], limits.torque[j]),
        )
        for j in range(q.shape[1])
    ]
    gaps, pairs = bodies.clearance(q), len(bodies.pairs)
    low = pairs + len(bodies.grounded)
    return Margins(
        joints=joints,
        own=_nearest(t, gaps[:, :pairs], bodies, 0),
        floor=_nearest(t, gaps[:, pairs:low], bodies, pairs),
        boxes=_nearest(t, gaps[:, low:], bodies, low),
    )


def poses_of(whole: Whole) -> Poses:
    """Of a motion, to be looked at."""
    t, q = whole.samples.t, whole.samples.q
    every = max(1, -(-len(q) // POSES))
    return Poses(
        dt=float(every * (t[1] - t[0])),
        poses=np.round(q[::every], DIGITS).tolist(),
        begins=float(t[min(whole.first, len(t) - 1)]),
        ends=float(t[whole.last - 1]),
        seconds=float(t[-1]),
    )


def _share(values: Array, limit: float) -> float | None:
    return float(np.abs(values).max() / limit) if np.isfinite(limit) else None


def _nearest(t: Array, gaps: Array, bodies: Capsules, first: int) -> Gap | None:
    if not gaps.size:
        return None
    row, column = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
    where = bodies.name(first + int(column))
    return Gap(float(gaps[row, column]), float(t[row]), where)
