"""The way back inside of an arm that stands outside its position limits: slow, and straight."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.control.outside import SLOW
from pa10d.dynamics import Robot
from pa10d.trajectory.check import CLOSE
from pa10d.trajectory.limits import DYNAMIC_SHARE, POSITION_MARGIN, limits_of
from pa10d.trajectory.plan import move
from pa10d.trajectory.poses import Surroundings

Array = NDArray[np.float64]

COMES_AFTER = 1.0  # s for a joint to be where its path has ended
MARGIN = 0.1  # of a joint's range, at most, that it comes inside


def place_inside(robot: Robot, q: Array) -> Array:
    """(n,) rad, each joint where it stands, or as far inside as plans keep from its limit."""
    limits = limits_of(robot)
    margin = np.minimum(POSITION_MARGIN, MARGIN * (limits.upper - limits.lower))
    out = (q < limits.lower) | (q > limits.upper)
    return np.where(out, np.clip(q, limits.lower + margin, limits.upper - margin), q)


def rows_back(robot: Robot, start: Array, rate: float) -> Array:
    """(N, 4n) rows for the loop at ``rate`` Hz from ``start`` (n,) rad to inside; UserError where
    a body would come nearer to another, or to what stands around, than is kept clear."""
    there = place_inside(robot, start)
    motion = move(start, there, limits_of(robot), gentle=DYNAMIC_SHARE * SLOW)
    t = np.arange(np.ceil((motion.duration + COMES_AFTER) * rate) + 1) / rate
    q, dq, ddq = motion.at(np.minimum(t, motion.duration))
    capsules = Surroundings.of(robot).capsules
    gaps = capsules.clearance(q)
    if gaps.size:
        lost = np.minimum(gaps[0], CLOSE) - gaps.min(axis=0)
        worst = int(np.argmax(lost))
        if lost[worst] > 0.0:
            raise UserError(
                f"the way back inside brings {capsules.name(worst)} to "
                f"{1e3 * gaps[:, worst].min():.0f} mm from each other; move the arm by hand"
            )
    return np.hstack([q, dq, ddq, np.zeros_like(q)])
