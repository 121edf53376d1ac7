"""What a motion may do: limits per joint, and the margin a plan keeps from them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics import Robot

Array = NDArray[np.float64]

UNKNOWN_SPEED = 1.0  # rad/s (m/s) where neither profile nor URDF names one
UNKNOWN_TURN = np.pi  # rad to either side of a joint that may turn for ever
ACCELERATION_PER_SPEED = 3.0  # 1/s: an unknown acceleration limit, reached from rest in 1/3 s
DYNAMIC_SHARE = 0.99  # of velocity and acceleration that a plan uses
TORQUE_SHARE = 0.9  # of torque: friction and tracking need the rest
POSITION_MARGIN = 0.03  # rad (m) kept from either end
TWICE = 3.5 * np.pi  # rad of range: an upper arm of ±2π gets behind itself through the floor only


@dataclass(frozen=True)
class MotionLimits:
    """lower, upper rad; velocity rad/s; acceleration rad/s²; torque N·m (inf where unknown),
    each (n,). ``assumed`` says in words what no profile and no URDF gave; home: rad, if stated."""

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    torque: Array
    assumed: tuple[str, ...] = ()
    home: Array | None = None

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.lower)

    @property
    def middle(self) -> Array:
        """(n,) centre of the position range."""
        return 0.5 * (self.lower + self.upper)

    @property
    def half(self) -> Array:
        """(n,) half of the position range."""
        return 0.5 * (self.upper - self.lower)

    def rest_pose(self) -> Array:
        """(n,) home; where none is stated, zero if that is well inside the range, else the middle
        of the range."""
        if self.home is not None:
            return self.home.copy()
        inside = (self.lower < 0) & (self.upper > 0)
        return np.where(inside, 0.0, self.middle)

    def planned(
        self,
        dynamic: float = DYNAMIC_SHARE,
        torque: float = TORQUE_SHARE,
        position: float = POSITION_MARGIN,
    ) -> MotionLimits:
        """What a plan may use, so that tracking errors stay within the limits themselves."""
        lower, upper = self.lower + position, self.upper - position
        bad = np.flatnonzero(lower >= upper)
        if bad.size:
            j = int(bad[0])
            raise UserError(
                f"joint {j + 1}: position limits {self.lower[j]:.3g} … {self.upper[j]:.3g} rad (m) "
                f"leave no room for a margin of {position:g} on either side; expected a wider range"
            )
        return replace(
            self,
            lower=lower,
            upper=upper,
            velocity=self.velocity * dynamic,
            acceleration=self.acceleration * dynamic,
            torque=self.torque * torque,
        )

    def within_a_turn(self, turns: NDArray[np.bool_]) -> MotionLimits:
        """Half a turn to either side of the rest pose, of joints that turn and have (nearly) every
        pose twice: the other one weighs and turns alike, and the way there may lead through the
        floor. turns: (n,)."""
        wide = turns & (self.upper - self.lower > TWICE)
        rest = self.rest_pose()
        return replace(
            self,
            lower=np.where(wide, np.maximum(self.lower, rest - np.pi), self.lower),
            upper=np.where(wide, np.minimum(self.upper, rest + np.pi), self.upper),
        )

    def of(self, joints: NDArray[np.int64]) -> MotionLimits:
        """The limits of some joints (0-based)."""
        return MotionLimits(
            self.lower[joints],
            self.upper[joints],
            self.velocity[joints],
            self.acceleration[joints],
            self.torque[joints],
            self.assumed,
            None if self.home is None else self.home[joints],
        )


def limits_of(robot: Robot) -> MotionLimits:
    """The robot's own limits; what is unknown is assumed, and said."""
    assumed = []
    lower = np.where(np.isfinite(robot.lower), robot.lower, -UNKNOWN_TURN)
    upper = np.where(np.isfinite(robot.upper), robot.upper, UNKNOWN_TURN)
    speed = np.where(np.isfinite(robot.velocity), robot.velocity, UNKNOWN_SPEED)
    rising = np.where(
        np.isfinite(robot.acceleration), robot.acceleration, ACCELERATION_PER_SPEED * speed
    )
    for known, words in (
        (np.isfinite(robot.lower) & np.isfinite(robot.upper), "position: ±π rad assumed"),
        (np.isfinite(robot.velocity), f"velocity: {UNKNOWN_SPEED:g} rad/s assumed"),
        (
            np.isfinite(robot.acceleration),
            f"acceleration: {ACCELERATION_PER_SPEED:g}/s × velocity assumed",
        ),
    ):
        if not known.all():
            joints = ", ".join(str(j + 1) for j in np.flatnonzero(~known))
            assumed.append(f"joint {joints}: no limit of {words}")
    return MotionLimits(
        lower, upper, speed, rising, robot.effort.copy(), tuple(assumed), robot.home
    )
