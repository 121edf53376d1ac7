"""Any motion, at a slower pace along the same way."""

from __future__ import annotations

from dataclasses import dataclass

from pa10d.trajectory.motions.base import Array, MotionState
from pa10d.trajectory.motions.derived import Derived


@dataclass(frozen=True)
class Slowed(Derived):
    """factor: by which everything takes longer."""

    name = "slowed"

    factor: float

    @property
    def duration(self) -> float:
        """s."""
        return self.factor * self._inner.duration

    @property
    def steady(self) -> tuple[float, float]:
        """The other one's, later."""
        begin, end = self._inner.steady
        return self.factor * begin, self.factor * end

    def at(self, t: Array) -> MotionState:
        """Same poses; speeds and accelerations fall with the factor and its square."""
        q, dq, ddq = self._inner.at(t / self.factor)
        return q, dq / self.factor, ddq / self.factor**2
