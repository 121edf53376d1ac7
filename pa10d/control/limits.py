"""What the arm may do, per joint, as the torque exit and the braking use it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.words import of_a_slide
from pa10d.dynamics import Robot
from pa10d.profile import Profile

Array = NDArray[np.float64]

BEYOND_RATED = 32.767  # times its rated torque: per mille of it (0x6071) have 16 bits
FOLLOWING_ERROR = 0.15  # rad (m): several times what a tuned servo leaves
FOLLOWING_TIME = 0.05  # s behind at full speed, where that is more
FULL_TORQUE_IN = 0.02  # s from zero to the torque limit: reversals pass, steps do not


@dataclass(frozen=True)
class ArmLimits:
    """(n,) each: rad, rad/s, rad/s², N·m, N·m/s, rad; stale_cycles: without a fresh value; slides:
    joints (0-based) of which all of that is in m and N."""

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    torque: Array
    torque_rate: Array
    following_error: Array
    stale_cycles: int = 3
    slides: frozenset[int] = frozenset()

    def in_units(self, axis: int, said: str) -> str:
        """What is said of this joint as of one that turns, in its own units."""
        return of_a_slide(said) if axis in self.slides else said


def arm_limits(profile: Profile, robot: Robot) -> ArmLimits:
    """Limits of a robot that is to be moved: every one must be known, or follow from another."""
    for values, key, unit in (
        (robot.velocity, "velocity", "rad/s"),
        (robot.acceleration, "acceleration", "rad/s²"),
        (robot.effort, "torque", "N·m"),
    ):
        for j in np.flatnonzero(~np.isfinite(values)):
            raise UserError(
                f"{profile.path}: limits.{key}: found nothing for joint {j + 1}, "
                f"expected a limit in {unit}; without it the arm may not be moved"
            )
    _refuse_beyond_drives(profile, robot)
    safety = profile.safety
    rate = safety.torque_rate or usual_torque_rate(robot).tolist()
    following = safety.following_error or usual_following_error(robot).tolist()
    return ArmLimits(
        lower=robot.lower.copy(),
        upper=robot.upper.copy(),
        velocity=robot.velocity.copy(),
        acceleration=robot.acceleration.copy(),
        torque=robot.effort.copy(),
        torque_rate=np.array(rate, dtype=float),
        following_error=np.array(following, dtype=float),
        stale_cycles=safety.stale_cycles,
        slides=frozenset(int(j) for j in np.flatnonzero(robot.prismatic)),
    )


def _refuse_beyond_drives(profile: Profile, robot: Robot) -> None:
    """UserError for a torque limit that is not of such a drive: another unit, or another motor."""
    if profile.drives is None:
        return
    for j, (drive, most) in enumerate(zip(profile.drives, robot.effort, strict=True), 1):
        rated = drive.rated_torque * drive.gear_ratio / drive.torque_gain
        if not rated / 1000.0 <= most <= BEYOND_RATED * rated:
            raise UserError(
                f"{profile.path}: limits.torque.{j}: found {most:.4g} N·m, expected at least a "
                f"thousandth and at most {BEYOND_RATED:g} times of what its drive is rated for, "
                f"{rated:.4g} N·m (rated_torque · gear_ratio / torque_gain)"
            )


def usual_following_error(robot: Robot) -> Array:
    """(n,) rad (m), where the profile names none."""
    return np.maximum(FOLLOWING_ERROR, FOLLOWING_TIME * robot.velocity)


def usual_torque_rate(robot: Robot) -> Array:
    """(n,) N·m/s (N/s), where the profile names none."""
    return np.asarray(robot.effort / FULL_TORQUE_IN)
