"""Arms that their URDF describes badly, in simulated time: measured, then moved."""

from __future__ import annotations

import numpy as np
import pytest
from arm_bench import ArmBench
from gain_grid import built, drawn

from pa10d.control.envelope import OVERSHOOT
from pa10d.control.joint_figures import presumed_figures
from pa10d.dynamics import robot_from_profile
from pa10d.services.joints import learnt, not_held
from pa10d.services.starting_set import STARTING_SET
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.plan import Plan

FRICTION_250 = {
    "coulomb": [8, 8, 4, 4, 0.7, 0.7, 0.7],
    "viscous": [10, 10, 5, 5, 0.5, 0.5, 0.5],
}


PLANS: dict[str, Plan] = {}


def planned(kind: str, parameters: dict) -> Plan:
    """Of the arm as its URDF has it; planned once."""
    asked = {"kind": kind, "parameters": parameters}
    if str(asked) not in PLANS:
        PLANS[str(asked)] = read_request(asked).build(ArmBench().around)
    return PLANS[str(asked)]


def fast_wrist() -> Plan:
    """The last joint at 5 rad/s."""
    return planned("tracking", {"joints": [7], "amplitude": 2.0, "period": 2.5, "cycles": 1})


def test_friction_at_250_hz_is_measured_and_met():
    """Gains by the URDF alone leave the last joint behind; after a first motion it follows."""
    arm = ArmBench(250.0, **FRICTION_250)
    arm.enable()
    _, fault = arm.run(fast_wrist())
    assert fault is not None
    assert (fault.kind, fault.axis) == ("following_error", 6)

    arm = ArmBench(250.0, **FRICTION_250)
    assert arm.first_motion() is None
    figures = arm.joints.figures
    np.testing.assert_allclose(figures.coulomb, arm.plant.dry, rtol=0.35)
    assert figures.rotor[6] == pytest.approx(arm.plant.rotor[6], rel=0.3)
    rows, fault = arm.run(fast_wrist())
    assert fault is None
    assert (arm.error(rows) < 0.1).all()


def test_a_torque_of_the_wrong_sign_is_named_before_the_joint_has_gone_far():
    for joint in (2, 4):
        signs = np.ones(7)
        signs[joint - 1] = -1.0
        arm = ArmBench(signs=signs, mass=0.9, pose=[0, 0.3, 0, 0.4, 0, 0.2, 0])
        start = arm.plant.measure()[0].copy()
        fault = arm.first_motion()
        assert fault is not None
        assert fault.axis == joint - 1
        assert fault.kind in ("wrong_sign", "not_held")
        assert "sign" in fault.sentence
        assert abs(arm.plant.measure()[0] - start)[joint - 1] < 0.1


def test_a_spring_is_told_from_a_light_joint():
    arm = built(**drawn(2))
    assert arm.first_motion() is None
    figures = arm.joints.figures
    assert figures.stiffness[1] == pytest.approx(1395.0, rel=0.1)
    assert figures.rotor[1] == pytest.approx(arm.plant.rotor[1], rel=0.2)


def test_a_joint_that_swings_gets_calmer_gains_and_is_tried_again():
    """Gains as for an arm ten times as heavy: it swings, and says so; then it does not."""
    arm = ArmBench(250.0, inertia=0.5, friction=0.3)
    arm.known = learnt(arm.profile, arm.robot, presumed_figures(arm.robot))
    arm.known.gains.kd[3] *= 10.0
    arm._use_known()
    plan = planned("first_motion", {"part": "friction"})
    fault = arm.enable() or arm.run(plan)[1]
    assert (fault.kind, fault.axis) == ("oscillation", 3)
    assert fault.hertz > 5.0
    assert arm._calm(fault)
    assert arm.notes[-1].startswith("joint 4 swung at ")
    assert arm.run(plan)[1] is None


def through_the_starting_set(arm):
    fault = arm.first_motion()
    assert fault is None, fault.sentence
    for entry in STARTING_SET[1:]:
        rows, fault = arm.run_on(planned(entry["kind"], entry["parameters"]))
        assert fault is None, fault.sentence
        assert (arm.error(rows) < arm.limits.following_error).all()
    assert (arm.beyond < OVERSHOOT).all()


def test_the_starting_set_runs_on_a_slow_arm_that_nobody_has_seen():
    """100 Hz; one of those that were not looked at while the rules were made."""
    through_the_starting_set(built(**drawn(1008)))


def test_a_spring_found_later_explains_the_swing_before_it():
    """What swung was the rotor in front of it: a free joint as light would leave no gains."""
    profile = ArmBench(100.0).profile
    robot = robot_from_profile(profile)

    def of_joint_2(value, others=0.0):
        return np.where(np.arange(7) == 1, value, others)

    presumed = presumed_figures(robot)
    before = presumed.but(swung=of_joint_2(0.26))
    found = presumed.but(
        stiffness=of_joint_2(755.0, np.inf), motor=of_joint_2(0.285), rotor=of_joint_2(0.285, 0.1),
        viscous=of_joint_2(10.0), link=of_joint_2(1.5, 1.0), delay=of_joint_2(0.005),
        doubt=np.full(7, 1.25),
    )  # fmt: skip
    rigid = found.but(stiffness=np.full(7, np.inf))
    swung = before.swung
    np.testing.assert_array_equal(found.after(before).swung, np.zeros(7))
    np.testing.assert_array_equal(rigid.after(before).swung, swung)
    assert not_held(learnt(profile, robot, found.after(before)), 100.0) is None
    said = not_held(learnt(profile, robot, found.but(swung=swung)), 100.0)
    assert said.startswith("joint 2: what was measured leaves no stable gains that hold it in ")
    assert "100 Hz; raise control.rate" in said


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize("seed", range(60))
def test_the_starting_set_runs_on_arms_that_nobody_has_seen(seed):
    through_the_starting_set(built(**drawn(seed)))
