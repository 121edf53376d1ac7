"""A motion that is refused because it could not be followed says which rate would do."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pa10d.control.gains import fitted_gains
from pa10d.control.joint_figures import MEASURED, presumed_figures
from pa10d.control.limits import arm_limits
from pa10d.dynamics import robot_from_profile
from pa10d.experiments.pacing import Joints, paced
from pa10d.experiments.slower import AS_ASKED
from pa10d.profile import load_profile
from pa10d.services import faster
from pa10d.services.faster import ways_to_follow
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.poses import Surroundings

RUBS = 0.1  # of the torque limit


def slow_arm(rate, bandwidth=None, made=fitted_gains):
    """A PA10 that rubs much, as measured, with the gains of this rate."""
    profile = load_profile("pa10-sim")
    update = {"rate": rate, "bandwidth_hz": bandwidth}
    control = profile.control.model_copy(update=update)
    profile = profile.model_copy(update={"control": control})
    robot = robot_from_profile(profile)
    rough = presumed_figures(robot).but(doubt=MEASURED * np.ones(7), coulomb=RUBS * robot.effort)
    bound = arm_limits(profile, robot).following_error
    gains = made(robot, profile.control, bound, rough).gains
    plan = read_request({"kind": "point_to_point", "parameters": {}}).build(Surroundings.of(robot))
    return profile, robot, plan, Joints(rough, gains, ahead=False)


@pytest.mark.long
def test_the_rate_that_is_named_is_not_refused():
    profile, robot, plan, joints = slow_arm(100.0)
    said = ways_to_follow(profile, robot, plan, plan.start, joints, AS_ASKED)
    assert said.startswith("raise control.rate to 200 Hz and run first_motion again")
    for rate, level in ((125.0, "error"), (200.0, "warning")):
        _, _, _, then = slow_arm(rate)
        bounds = arm_limits(profile, robot)
        assert paced(plan, plan.start, robot, bounds, rate, then).check.level == level


@pytest.mark.parametrize(
    ("enough", "bandwidth", "says"),
    [
        (250.0, None, "raise control.rate to 250 Hz and run first_motion again"),
        (100.0, 0.5, "leave out bandwidth_hz and run first_motion again"),
        (250.0, 0.5, "raise control.rate to 250 Hz, leave out bandwidth_hz and run"),
        (1000.0, None, "no control.rate that this bus carries, up to 585 Hz, would do"),
    ],
)
def test_no_rate_is_named_that_the_bus_does_not_carry(monkeypatch, enough, bandwidth, says):
    def made(*asked):
        return SimpleNamespace(gains=None, sensitivity=np.ones(7))

    def answer(plan, start, robot, limits, rate, *more):
        return SimpleNamespace(check=SimpleNamespace(level="ok" if rate >= enough else "error"))

    profile, robot, plan, joints = slow_arm(100.0, bandwidth, made)
    monkeypatch.setattr(faster, "fitted_gains", made)
    monkeypatch.setattr(faster, "paced", answer)
    assert says in ways_to_follow(profile, robot, plan, plan.start, joints, AS_ASKED)
