"""Drive numbers and joint-side SI units of one axis, as the profile defines them."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from pa10d.profile import Drive


@dataclass(frozen=True)
class Scaling:
    """Counts, per mille and radians of one axis."""

    sign: int
    counts_per_radian: float
    zero_offset: float  # rad
    rated: float  # N·m at the joint for 1000 per mille

    def counts(self, q: float) -> int:
        """Encoder counts at joint angle ``q`` (rad)."""
        return round(self.sign * (q + self.zero_offset) * self.counts_per_radian)

    def angle(self, counts: float) -> float:
        """Joint angle (rad) at ``counts``."""
        return self.sign * counts / self.counts_per_radian - self.zero_offset

    def torque(self, per_mille: float) -> float:
        """N·m at the joint."""
        return self.sign * per_mille * self.rated / 1000.0

    def per_mille(self, torque: float) -> int:
        """Per mille of the rated torque for ``torque`` N·m at the joint."""
        return round(self.sign * torque * 1000.0 / self.rated)


def scaling_of(drive: Drive) -> Scaling:
    """The scaling that a profile's drive entry states."""
    return Scaling(
        sign=drive.sign,
        counts_per_radian=drive.counts_per_rev / (2 * pi),
        zero_offset=drive.zero_offset,
        rated=drive.rated_torque * drive.gear_ratio / drive.torque_gain,
    )


def nameplate(drive: Drive) -> Scaling:
    """The scaling that the drive itself believes in: nobody told it of a known weight."""
    return scaling_of(drive.model_copy(update={"torque_gain": 1.0}))
