"""Motions that never rest, such as sines, entered and left along their own path.

A clock that speeds up from standstill drives the path: no pose is visited that the path would not
visit anyway, so what holds for the path (limits of position, collisions, floor) holds on the way
in and out. The clock's own acceleration is added to that of the path: ``gentle`` finds a lead that
is long enough.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.trajectory.limits import MotionLimits
from pa10d.trajectory.motions.base import Motion, MotionState

Array = NDArray[np.float64]

LEADS = (1.0, 1.5, 2.0, 3.0, 4.5, 7.0, 10.0, 15.0, 22.0)  # s that are tried
LOOK = 200.0  # Hz at which a lead is looked at


@dataclass(frozen=True)
class Entered(Motion):
    """A path, followed for ``seconds`` at its own pace, with ``lead`` s before and after."""

    seconds: float
    lead: float

    @abstractmethod
    def path(self, t: Array) -> MotionState:
        """q, dq, ddq at path times t (N,), also outside of 0 … seconds."""

    @property
    def duration(self) -> float:
        """s, leads included."""
        return self.seconds + 2 * self.lead

    @property
    def steady(self) -> tuple[float, float]:
        """The part at full pace."""
        return self.lead, self.lead + self.seconds

    def at(self, t: Array) -> MotionState:
        """The path by a clock that starts and stops smoothly."""
        before = self.lead - t
        after = t - self.lead - self.seconds
        late = np.clip(np.maximum(before, after) / self.lead, 0.0, 1.0) if self.lead else 0.0 * t
        x, side = 1.0 - late, np.where(after > 0, -1.0, 1.0)
        # pace 3x²-2x³ is smooth at both ends; its integral from rest to full pace is lead/2
        outside = self.lead * (0.5 - x**3 + 0.5 * x**4)
        clock = np.where(after > 0, self.seconds + outside, t - self.lead)
        clock = np.where(before > 0, -outside, clock)
        pace = 3 * x**2 - 2 * x**3
        change = side * (6 * (x - x**2) / self.lead) if self.lead else 0.0 * t
        q, dq, ddq = self.path(clock)
        return q, dq * pace[:, None], ddq * pace[:, None] ** 2 + dq * change[:, None]

    def gentle(self, limits: MotionLimits) -> Self:
        """The same with the shortest lead whose accelerations stay within the limits."""
        for lead in LEADS:
            tried = replace(self, lead=lead)
            t = np.arange(0.0, lead, 1 / LOOK)
            both = np.concatenate([t, tried.duration - t])
            if np.all(np.abs(tried.at(both)[2]) <= limits.acceleration * (1 + 1e-9)):
                return tried
        fast = np.argmax(np.abs(self.path(np.linspace(0, self.seconds, 2000))[2]).max(axis=0))
        raise UserError(
            f"joint {fast + 1}: the motion itself uses up the acceleration limit of "
            f"{limits.acceleration[fast]:.3g} rad/s², nothing is left to enter it from rest; "
            "expected smaller amplitudes or lower frequencies"
        )
