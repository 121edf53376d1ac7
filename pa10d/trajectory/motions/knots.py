"""Fifth-order pieces between knots: moves from rest to rest, pauses, constant speeds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.trajectory.motions.base import Motion, MotionState

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Knots(Motion):
    """times (k,) s from 0; q, dq, ddq (k, n) there. Between two knots runs the one quintic that
    meets both; for equal speeds and matching distance it is the straight line.

    window (2,) s: the part that an analysis looks at
    """

    name = "knots"

    times: Array
    q: Array
    dq: Array
    ddq: Array
    window: Array

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.q.shape[1]

    @property
    def duration(self) -> float:
        """s."""
        return float(self.times[-1])

    @property
    def steady(self) -> tuple[float, float]:
        """The window."""
        return float(self.window[0]), float(self.window[1])

    def at(self, t: Array) -> MotionState:
        """The quintics; beyond the ends the end poses."""
        inside = np.clip(t, 0.0, self.times[-1])
        piece = np.clip(
            np.searchsorted(self.times, inside, side="right") - 1, 0, len(self.times) - 2
        )
        length = np.diff(self.times)[piece][:, None]
        s = (inside - self.times[piece])[:, None] / length
        start, end = (
            (self.q[k], self.dq[k] * length, self.ddq[k] * length**2) for k in (piece, piece + 1)
        )
        # remainder beyond the starting parabola, met by a cubic times s³
        e0 = end[0] - start[0] - start[1] - 0.5 * start[2]
        e1 = end[1] - start[1] - start[2]
        e2 = end[2] - start[2]
        c3, c4, c5 = 10 * e0 - 4 * e1 + 0.5 * e2, -15 * e0 + 7 * e1 - e2, 6 * e0 - 3 * e1 + 0.5 * e2
        q = start[0] + s * (start[1] + s * (0.5 * start[2] + s * (c3 + s * (c4 + s * c5))))
        dq = start[1] + s * (start[2] + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))
        ddq = start[2] + s * (6 * c3 + s * (12 * c4 + s * 20 * c5))
        return q, dq / length, ddq / length**2


class Drawing:
    """Knots drawn one stroke after the other, all joints at once, from rest."""

    def __init__(self, pose: Array) -> None:
        self.time = 0.0
        self._times = [0.0]
        self._q = [np.array(pose, dtype=float)]
        self._dq = [np.zeros(len(pose))]

    @property
    def pose(self) -> Array:
        """Where the drawing stands."""
        return self._q[-1]

    def to(self, pose: Array, seconds: float, speed: Array | None = None) -> None:
        """On to a pose, reached at ``speed`` (default: rest)."""
        self.time += seconds
        self._times.append(self.time)
        self._q.append(np.array(pose, dtype=float))
        self._dq.append(np.zeros(len(pose)) if speed is None else np.array(speed, dtype=float))

    def rest(self, seconds: float) -> None:
        """Stay."""
        self.to(self.pose, seconds)

    def cruise(self, velocity: Array, seconds: float, ramp: float) -> tuple[float, float]:
        """Speed up, run at constant velocity, brake; returns begin and end of the constant part."""
        self.to(self.pose + 0.5 * velocity * ramp, ramp, velocity)
        begin = self.time
        self.to(self.pose + velocity * seconds, seconds, velocity)
        end = self.time
        self.to(self.pose + 0.5 * velocity * ramp, ramp)
        return begin, end

    def knots(self, begin: float = 0.0, end: float | None = None) -> Knots:
        """What was drawn; begin … end: the window (default: all of it)."""
        q = np.array(self._q)
        window = np.array([begin, self.time if end is None else end])
        return Knots(np.array(self._times), q, np.array(self._dq), np.zeros_like(q), window)


QUINTIC_SPEED, QUINTIC_RISE = 1.875, 10 / np.sqrt(3)  # of span/T and span/T²
RAMP_RISE = 1.5  # of speed/ramp: peak acceleration of a smooth ramp


def move_time(span: Array, velocity: Array, acceleration: Array) -> float:
    """s that a quintic from rest to rest over span (n,) needs within these limits."""
    size = np.abs(span)
    by_speed = QUINTIC_SPEED * size / velocity
    by_rise = np.sqrt(QUINTIC_RISE * size / acceleration)
    return float(max(by_speed.max(), by_rise.max()))


def ramp_time(speed: Array, acceleration: Array) -> float:
    """s in which a speed (n,) is reached smoothly within the acceleration limit."""
    return float((RAMP_RISE * np.abs(speed) / acceleration).max())
