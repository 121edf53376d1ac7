"""What of ``control`` would let a motion be followed that the pre-check refuses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.control.gains import fitted_gains
from pa10d.control.limits import arm_limits
from pa10d.dynamics import Robot
from pa10d.experiments.pacing import Joints, paced
from pa10d.experiments.slower import Slower
from pa10d.profile import Profile
from pa10d.services.joints import FASTER, most_rate
from pa10d.trajectory.plan import Plan

Array = NDArray[np.float64]

OTHERWISE = "use computed torque with a model, or a smaller motion"


def ways_to_follow(
    profile: Profile, robot: Robot, plan: Plan, start: Array, joints: Joints, slower: Slower
) -> str:
    """The remedy of a refusal. Each rate is looked at by the same pre-check, with the gains that it
    allows these joints as they were measured, and none that the bus does not carry."""
    most, now = most_rate(profile), profile.control.rate
    wider = profile.control.model_copy(update={"bandwidth_hz": None})
    bounds = arm_limits(profile, robot)
    changes = [] if profile.control.bandwidth_hz is None else [(now, "leave out bandwidth_hz")]
    changes += [(r, f"raise control.rate to {r:g} Hz") for r in FASTER if now < r <= most]
    for rate, words in changes:
        control = wider.model_copy(update={"rate": rate})
        gains = fitted_gains(robot, control, bounds.following_error, joints.figures)
        if not np.isfinite(gains.sensitivity).all():
            continue
        tried = Joints(joints.figures, gains.gains, joints.ahead)
        if paced(plan, start, robot, bounds, rate, tried, slower).check.level != "error":
            also = "" if profile.control.bandwidth_hz is None else ", leave out bandwidth_hz"
            words = words if rate == now else words + also
            return f"{words} and run first_motion again, or {OTHERWISE}"
    if not np.isfinite(most):
        return f"{OTHERWISE}; no faster control.rate would do"
    return (
        f"{OTHERWISE}; no control.rate that this bus carries, up to {np.floor(most):g} Hz, would do"
    )
