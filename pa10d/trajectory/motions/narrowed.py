"""Any motion, with some joints turning less far."""

from __future__ import annotations

from dataclasses import dataclass

from pa10d.trajectory.motions.base import Array, MotionState
from pa10d.trajectory.motions.derived import Derived


@dataclass(frozen=True)
class Narrowed(Derived):
    """share, about (n,): how far of its way each joint turns away from where, rad."""

    name = "narrowed"

    share: Array
    about: Array

    def at(self, t: Array) -> MotionState:
        """Ways, speeds and accelerations fall with the share."""
        q, dq, ddq = self._inner.at(t)
        return self.about + self.share * (q - self.about), self.share * dq, self.share * ddq
