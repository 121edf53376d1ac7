"""Any motion, at a slower pace along the same way."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pa10d.trajectory.motions.base import Array, Motion, State, motion_from_dict


@dataclass(frozen=True)
class Slowed(Motion):
    """factor: by which everything takes longer; original: the other one, as a file holds it."""

    name = "slowed"

    factor: float
    original: dict[str, Any]

    @cached_property
    def _inner(self) -> Motion:
        return motion_from_dict(self.original)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self._inner.n

    @property
    def duration(self) -> float:
        """s."""
        return self.factor * self._inner.duration

    @property
    def steady(self) -> tuple[float, float]:
        """The other one's, later."""
        begin, end = self._inner.steady
        return self.factor * begin, self.factor * end

    def at(self, t: Array) -> State:
        """Same poses; speeds and accelerations fall with the factor and its square."""
        q, dq, ddq = self._inner.at(t / self.factor)
        return q, dq / self.factor, ddq / self.factor**2
