"""Does the cyclic traffic fit on the wire? Worst-case bits, stuffing included, against bitrate.

Frame length after Davis, Burns, Bril and Lukkien, "Controller Area Network (CAN) schedulability
analysis: refuted, revisited and revised" (2007), 11-bit identifiers, interframe space counted.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

from pa10d.common.errors import UserError
from pa10d.profile import Profile

RPDO_BYTES = 4  # 6040 controlword + 6071 target torque
TPDO_BYTES = 8  # 6064 position + 6077 torque + 6041 statusword
SDO_BYTES = 8
HEARTBEAT_BYTES = 1


def worst_case_bits(data_bytes: int) -> int:
    """Longest possible frame with ``data_bytes`` of data, bits on the wire."""
    return 47 + 8 * data_bytes + (34 + 8 * data_bytes - 1) // 4


@dataclass(frozen=True)
class BusBudget:
    """Worst-case use of one bus; loads are shares of the bitrate (1.0 = full)."""

    axes: int
    bitrate: int  # bit/s
    rate: float  # Hz, asked for
    cycle_bits: int  # SYNC + one RPDO and one TPDO per axis
    heartbeat_load: float
    sdo_load: float  # kept free for SDO, EMCY and NMT
    max_rate: float  # Hz

    @property
    def cycle_load(self) -> float:
        """Share taken by the cyclic frames at the asked rate."""
        return self.cycle_bits * self.rate / self.bitrate

    @property
    def load(self) -> float:
        """Share taken by everything, reserve included."""
        return self.cycle_load + self.heartbeat_load + self.sdo_load

    @property
    def fits(self) -> bool:
        return self.rate <= self.max_rate

    def sentence(self) -> str:
        """The budget in one line."""
        return (
            f"{self.axes} axes at {self.rate:g} Hz on {self.bitrate / 1000:g} kbit/s: "
            f"{self.cycle_bits} bits a cycle at worst, {100 * self.load:.1f} % of the wire "
            f"(cycle {100 * self.cycle_load:.1f}, heartbeats {100 * self.heartbeat_load:.1f}, "
            f"SDO reserve {100 * self.sdo_load:.1f}); at most {floor(self.max_rate)} Hz fits"
        )


def bus_budget(
    axes: int, rate: float, bitrate: int, heartbeat_ms: list[float], sdo_reserve: float
) -> BusBudget:
    """Budget of ``axes`` drives at ``rate`` Hz; ``heartbeat_ms`` has one period per producer."""
    cycle = worst_case_bits(0) + axes * (worst_case_bits(RPDO_BYTES) + worst_case_bits(TPDO_BYTES))
    heartbeats = sum(worst_case_bits(HEARTBEAT_BYTES) * 1000.0 / ms for ms in heartbeat_ms)
    free = bitrate * (1.0 - sdo_reserve) - heartbeats
    return BusBudget(
        axes=axes,
        bitrate=bitrate,
        rate=rate,
        cycle_bits=cycle,
        heartbeat_load=heartbeats / bitrate,
        sdo_load=sdo_reserve,
        max_rate=max(free, 0.0) / cycle,
    )


def profile_budget(profile: Profile) -> BusBudget:
    """The budget of a profile: its drives and the control PC send heartbeats."""
    drives = profile.drives or []
    periods = [float(drive.heartbeat_ms) for drive in drives]
    return bus_budget(
        axes=len(drives),
        rate=profile.control.rate,
        bitrate=profile.can.bitrate,
        heartbeat_ms=[*periods, min(periods)] if periods else [],
        sdo_reserve=profile.can.sdo_reserve,
    )


def wrong_with_rate(profile: Profile, budget: BusBudget) -> str | None:
    """Which rate the profile asks for, and the highest one that fits: one line, or None."""
    if budget.fits:
        return None
    return (
        f"{profile.path}: control.rate: found {budget.rate:g} Hz, expected at most "
        f"{floor(budget.max_rate)} Hz on {budget.bitrate / 1000:g} kbit/s ({budget.sentence()})"
    )


def require_fit(profile: Profile) -> BusBudget:
    """The profile's budget, or UserError with the highest rate that fits."""
    budget = profile_budget(profile)
    if (wrong := wrong_with_rate(profile, budget)) is not None:
        raise UserError(wrong)
    return budget
