"""A joint that may err keeps that much room to its position limits, before anything moves."""

import re
from dataclasses import replace

import numpy as np
import pytest

from pa10d.control.joint_figures import presumed_figures
from pa10d.control.limits import arm_limits
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.dynamics.mass import mass_matrices
from pa10d.experiments.measured_joints import lowered
from pa10d.experiments.motion import whole_motion
from pa10d.experiments.pacing import Adjusted, Joints, paced
from pa10d.experiments.prediction import PACES
from pa10d.experiments.slower import AS_ASKED, Slower
from pa10d.profile import load_profile
from pa10d.services.joints import learnt
from pa10d.trajectory.plan import Plan, Segment, move
from pa10d.trajectory.poses import Surroundings

RATE, JOINT, NEAR = 200.0, 3, 0.01  # Hz, 0-based, rad
HEAVIER = 1.5  # times what the URDF says


@pytest.fixture(scope="module")
def arm():
    """Profile, robot, limits, and a plan that comes close to a limit of one joint."""
    profile = load_profile("pa10-sim")
    robot = robot_from_profile(profile)
    limits, around = arm_limits(profile, robot), Surroundings.of(robot)
    far = np.zeros(robot.n)
    far[JOINT] = limits.upper[JOINT] - NEAR
    there = Segment(move(np.zeros(robot.n), far, around.limits))
    back = Segment(move(far, np.zeros(robot.n), around.limits))
    return profile, robot, limits, Plan("point_to_point", (JOINT + 1,), (there, back))


def measured(profile, robot, heavier=1.0):
    """An arm that may be ``heavier`` than what it is given ahead."""
    known = learnt(profile, robot, presumed_figures(robot))
    bodies = np.stack([robot.parameters, heavier * robot.parameters])
    return Joints(known.figures.but(bodies=bodies), known.gains, ahead=True)


def nearest(chosen, limits):
    q = chosen.whole.samples.q
    return float((limits.upper - q.max(axis=0))[JOINT])


def test_a_joint_that_follows_goes_all_the_way(arm):
    profile, robot, limits, plan = arm
    chosen = paced(plan, plan.start, robot, limits, RATE, measured(profile, robot))
    assert chosen.plan is plan
    assert chosen.check.level == "ok"
    assert chosen.adjusted.document() is None
    assert nearest(chosen, limits) == pytest.approx(NEAR, abs=1e-6)


def test_a_joint_that_may_err_keeps_that_much_from_its_limit(arm):
    profile, robot, limits, plan = arm
    joints = measured(profile, robot, HEAVIER)
    chosen = paced(plan, plan.start, robot, limits, RATE, joints)
    again = paced(chosen.plan, plan.start, robot, limits, RATE, joints)
    assert chosen.check.level == "warning"
    assert f"turned less far, to keep clear of position limits (joint {JOINT + 1}: " in (
        chosen.check.sentence
    )
    told = chosen.adjusted.document()
    assert [one["joint"] for one in told["less_far"]] == [JOINT + 1]
    assert told["pace"] == 1.0
    done, asked = (p.sample(RATE).q[:, JOINT].max() for p in (chosen.plan, plan))
    middle = 0.5 * (limits.upper + limits.lower)[JOINT]
    left_out = 1.0 - (done - middle) / (asked - middle)
    assert told["less_far"][0]["share"] == pytest.approx(left_out, rel=1e-6)
    assert told["sentence"].startswith("Not quite as asked for: turned less far")
    assert nearest(chosen, limits) > 1.5 * NEAR
    assert again.plan is chosen.plan  # it has its room now
    assert again.check.level == "ok"
    kept = Plan.from_dict(chosen.plan.to_dict())
    np.testing.assert_allclose(kept.sample(RATE).q, chosen.plan.sample(RATE).q)


def test_where_there_is_no_room_the_motion_is_refused(arm):
    profile, robot, limits, plan = arm
    upper, lower = limits.upper.copy(), limits.lower.copy()
    upper[JOINT - 2], lower[JOINT - 2] = 1e-4, -1e-4  # joint 2 carries what the other one moves
    narrow = replace(limits, upper=upper, lower=lower)
    chosen = paced(plan, plan.start, robot, narrow, RATE, measured(profile, robot, HEAVIER))
    assert chosen.check.level == "error"
    assert chosen.plan is plan
    assert f"joint {JOINT - 1} comes close to its position limit" in chosen.check.sentence
    assert "a smaller motion" in chosen.check.sentence


def test_a_motion_that_is_too_fast_is_slowed_and_says_how_much(arm):
    profile, robot, limits, plan = arm
    tight = replace(limits, following_error=0.07 * limits.following_error)
    chosen = paced(plan, plan.start, robot, tight, RATE, measured(profile, robot, HEAVIER))
    told = chosen.adjusted.document()
    assert told["pace"] > 1.0
    assert f"run at 1/{told['pace']:g} of the speed" in told["sentence"]
    assert told["why"] in told["sentence"]
    seconds = [p.sample(RATE).q.shape[0] / RATE for p in (plan, chosen.plan)]
    assert seconds[1] == pytest.approx(told["pace"] * seconds[0], rel=0.02)


@pytest.mark.long
def test_a_joint_that_is_followed_at_no_pace_turns_less_far(arm):
    """What gravity may be off by stays, however slow the motion is."""
    profile, robot, limits, _ = arm
    there = np.zeros(robot.n)
    there[JOINT] = 0.5
    around = Surroundings.of(robot)
    plan = Plan("point_to_point", (JOINT + 1,), (Segment(move(0.0 * there, there, around.limits)),))
    joints = measured(profile, robot, HEAVIER)
    soft = replace(joints.gains, ki=0.0 * joints.gains.ki)  # nothing makes up for it in time
    for share in np.geomspace(1.0, 0.01, 24):
        tight = replace(limits, following_error=share * limits.following_error)
        chosen = paced(plan, plan.start, robot, tight, RATE, replace(joints, gains=soft))
        told = chosen.adjusted and chosen.adjusted.document()
        if chosen.check.level == "error" or (told and told["smaller"]):
            break
    assert chosen.check.level == "warning", chosen.check.sentence
    assert told["pace"] == PACES[-1]
    assert "turned less far, to keep to their paths" in told["sentence"]
    assert JOINT + 1 in [one["joint"] for one in told["smaller"]]
    assert all(0.0 < one["share"] <= 0.5 for one in told["smaller"])


def test_torque_is_judged_by_the_bodies_as_they_were_felt(arm):
    """A URDF that is too heavy by half refused what the arm can carry, and moved it no less far."""
    profile, robot, limits, plan = arm
    known = measured(profile, robot)
    light = replace(known, figures=known.figures.but(bodies=0.4 * robot.parameters[None]))
    _, *way = whole_motion(plan, plan.start, robot, RATE).samples
    asked = np.abs(inverse_dynamics(robot, robot.parameters, *way)).max(axis=0)
    weak = replace(robot, effort=np.where(asked > 1.0, 0.8 * asked, robot.effort))
    carried = paced(plan, plan.start, weak, replace(limits, torque=weak.effort), RATE, light)
    urdf = whole_motion(plan, plan.start, weak, RATE).violations
    assert [v.kind for v in urdf] == ["torque"] * len(urdf)
    assert len(urdf) > 0
    assert carried.check.level != "error"
    assert carried.whole.violations == ()
    lead = replace(known, figures=known.figures.but(bodies=4.0 * robot.parameters[None]))
    refused = paced(plan, plan.start, weak, replace(limits, torque=weak.effort), RATE, lead)
    assert refused.check.level == "error"


def test_a_servo_that_is_slower_than_asked_for_is_said_to_be():
    profile = load_profile("pa10-sim")
    fast = profile.control.model_copy(update={"rate": 100.0, "bandwidth_hz": 4.0})
    profile = profile.model_copy(update={"control": fast})
    robot = robot_from_profile(profile)
    known = learnt(profile, robot, presumed_figures(robot))
    assert known.asked == 4.0
    slower = [j for j, hz in enumerate(known.bandwidth, 1) if hz < 0.9 * 4.0]
    assert slower
    said = lowered(known.asked, known.bandwidth)
    assert [int(j) for j in re.findall(r"joint (\d)", said)] == slower
    assert lowered(4.0, [4.0, 3.9]) is None


def test_a_motion_that_would_throw_a_link_about_on_its_spring_is_slowed(arm):
    """The motor may be on its path all the while: what is checked for room is the path."""
    profile, robot, limits, _ = arm
    upright, swings = 0, 0.3  # 0-based, Hz
    there = np.zeros(robot.n)
    there[upright] = 1.0
    around = Surroundings.of(robot)
    way = Segment(move(np.zeros(robot.n), there, around.limits))
    plan = Plan("point_to_point", (upright + 1,), (way,))
    joints = measured(profile, robot)
    rotor = 10.0 * joints.figures.rotor  # stiff enough a servo to stay on its path
    link = mass_matrices(robot, np.zeros((1, robot.n)))[0, upright, upright]
    stiffness = np.full(robot.n, np.inf)
    stiffness[upright] = link * (2.0 * np.pi * swings) ** 2
    soft = joints.figures.but(stiffness=stiffness, motor=rotor)
    quiet = replace(limits, following_error=10.0 * limits.following_error)
    chosen = paced(plan, plan.start, robot, limits, RATE, replace(joints, figures=soft))
    free = paced(plan, plan.start, robot, quiet, RATE, replace(joints, figures=soft))
    assert chosen.check.level == "warning", chosen.check.sentence
    assert re.search(r"joint 1's link would swing by 0\.\d+ rad", chosen.adjusted.why)
    assert chosen.adjusted.pace > free.adjusted.pace


def test_where_weights_alone_are_in_doubt_a_smaller_motion_is_run_before(arm):
    """None of its own; its carrier falls behind by what the others may weigh."""
    profile, robot, limits, _ = arm
    there = np.zeros(robot.n)
    there[[1, 3, 5]] = 0.7, 0.9, 0.8
    plan = Plan("point_to_point", (2, 4, 6), (
        Segment(move(0.0 * there, there, Surroundings.of(robot).limits)),))  # fmt: skip
    joints = measured(profile, robot, HEAVIER)
    soft = replace(joints, gains=replace(joints.gains, ki=0.0 * joints.gains.ki))
    bound = limits.following_error

    def tried(share, joints, slower=AS_ASKED):
        tight = replace(limits, following_error=share * bound)
        return paced(plan, plan.start, robot, tight, RATE, joints, slower)

    shares = np.geomspace(0.5, 0.01, 16)
    share, first = next(
        (share, one) for share in shares if (one := tried(share, soft)).weighs is not None
    )
    assert first.check.level == "warning"
    assert f"{first.weighs:.0%} of it is run before" in first.check.sentence
    small = tried(share, soft, Slower(small=first.weighs))
    assert small.check.level != "error"
    turned = np.abs(small.plan.sample(RATE).q).max(axis=0)
    assert (turned[[1, 3, 5]] <= first.weighs * there[[1, 3, 5]] + 1e-9).all()
    alone = soft.figures.but(bodies=soft.figures.bodies[1:])  # it is sure to weigh as much
    sure = tried(share, replace(soft, figures=alone, ahead=False))
    assert (sure.check.level, sure.weighs) == ("error", None)


def test_a_way_that_nobody_sees_is_not_spoken_of():
    """ "turned less far, to keep clear of position limits (joint 6: 0.00097 %)" was said."""
    assert Adjusted(1.0, "", {6: 9.7e-6}).document() is None
    assert "(joint 2: 5 %)" in Adjusted(1.0, "", {2: 0.05, 6: 9.7e-6}).phrases[0]
