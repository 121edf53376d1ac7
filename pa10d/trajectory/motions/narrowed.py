"""Any motion, with some joints turning less far."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pa10d.trajectory.motions.base import Array, Motion, State, motion_from_dict


@dataclass(frozen=True)
class Narrowed(Motion):
    """share, about (n,): how far of its way each joint turns away from where, rad; original: the
    other motion, as a file holds it."""

    name = "narrowed"

    share: Array
    about: Array
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
        return self._inner.duration

    @property
    def steady(self) -> tuple[float, float]:
        """The other one's."""
        return self._inner.steady

    def at(self, t: Array) -> State:
        """Ways, speeds and accelerations fall with the share."""
        q, dq, ddq = self._inner.at(t)
        return self.about + self.share * (q - self.about), self.share * dq, self.share * ddq
