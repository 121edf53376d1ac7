"""Viscous friction of a joint with a soft servo is measured before it strokes, by strokes so short
that it cannot fall behind by more than it may."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from small_arm import joints_of_the_arm

from pa10d.control.gains import BUS_DELAY
from pa10d.control.joint_figures import likely_figures
from pa10d.control.limits import arm_limits
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.experiments.measured_joints import measured_figures
from pa10d.experiments.seen import Seen
from pa10d.profile import load_profile
from pa10d.services.joints import begun, soft
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.poses import Surroundings

SLOW, FAST = 100.0, 500.0  # Hz
DRY, WET = np.array([20.0, 20.0, 8.0]), np.array([30.0, 30.0, 10.0])  # N·m, N·m·s/rad
FOLLOWS = 0.6  # of the way that is asked for


@pytest.fixture(scope="module")
def profile(tmp_path_factory):
    path = tmp_path_factory.mktemp("sliding") / "arm.yaml"
    path.write_text(yaml.safe_dump(joints_of_the_arm()))
    return load_profile(str(path))


def at(profile, rate):
    control = profile.control.model_copy(update={"rate": rate, "bandwidth_hz": None})
    return profile.model_copy(update={"control": control})


def plan_of(robot, part, **parameters):
    asked = {"kind": "first_motion", "parameters": {"part": part, **parameters}}
    return read_request(asked).build(Surroundings.of(robot))


def rubs(robot, plan):
    """The part as it was seen, of joints that rub so and follow some of the way, each its own."""
    _, asked, *_ = plan.sample(SLOW)
    q = asked[0] + FOLLOWS * (asked - asked[0])
    dq = np.gradient(q, 1.0 / SLOW, axis=0)
    ddq = np.gradient(dq, 1.0 / SLOW, axis=0)
    rotor = likely_figures(robot).rotor * ddq
    torque = inverse_dynamics(robot, robot.parameters, q, dq, ddq) + rotor
    torque += DRY * np.sign(np.round(dq, 9)) + WET * dq
    rows = np.arange(len(q))  # what is sent acts later
    for j in range(robot.n):
        torque[:, j] = np.interp(rows + BUS_DELAY, rows, torque[:, j])
    return Seen(plan, SLOW, q, torque)


def test_short_strokes_are_shorter_than_a_joint_may_be_behind(profile):
    robot = robot_from_profile(profile)
    plan = plan_of(robot, "sliding", joints=[2, 3])
    assert {span.label for span in plan.spans} == {"joint 2 short", "joint 3 short"}
    q = plan.sample(SLOW).q
    assert np.ptp(q[:, 0]) == 0.0
    bound = arm_limits(profile, robot).following_error
    assert (np.ptp(q[:, 1:], axis=0) < 0.8 * bound[1:]).all()
    assert np.abs(plan.sample(SLOW).dq).max(axis=0)[1] > 0.2
    whole = read_request({"kind": "first_motion", "parameters": {}}).build(Surroundings.of(robot))
    assert not any(span.label.endswith(" short") for span in whole.spans), "only where it is needed"


def test_they_tell_what_small_slow_motions_do_not(profile):
    robot = robot_from_profile(profile)
    nudged = rubs(robot, plan_of(robot, "friction"))
    slid = rubs(robot, plan_of(robot, "sliding", joints=[2]))
    step = np.full(robot.n, 1e-3)
    before = measured_figures(robot, {"friction": nudged}, step)
    after = measured_figures(robot, {"friction": nudged, "sliding": slid}, step)
    assert after.viscous[1] == pytest.approx(0.7 * WET[1], rel=0.1)
    others = [0, 2]
    assert after.viscous[others] == pytest.approx(before.viscous[others]), (
        "they had no such strokes"
    )
    assert after.coulomb == pytest.approx(before.coulomb), "that slow motions tell better"


@pytest.mark.parametrize(("rate", "few"), [(SLOW, True), (FAST, False)])
def test_where_a_servo_is_soft_beside_friction(profile, rate, few):
    slow = at(profile, rate)
    robot = robot_from_profile(slow)
    figures = likely_figures(robot).but(coulomb=DRY, doubt=np.full(robot.n, 2.0))
    known, _ = begun(slow, robot, figures)
    found = soft(slow, robot, known)
    assert bool(found) == few
    damped = figures.but(viscous=1.2 * known.gains.kd)
    known = known.__class__(**{**vars(known), "figures": damped})
    assert soft(slow, robot, known) == [1, 2, 3], "it damps them more than their servo does"
