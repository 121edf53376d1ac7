"""A motion that ended against all prediction is tried again slower, unless something was met."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from arm_bench import ArmBench
from foreign_arms import built as foreign

from pa10d.control.faults import Fault
from pa10d.control.joint_figures import presumed_figures
from pa10d.experiments.pacing import Joints, paced
from pa10d.experiments.slower import MORE, SLOWEST, Slower, slower_after
from pa10d.services.joints import learnt
from pa10d.services.starting_set import STARTING_SET
from pa10d.trajectory.kinds import read_request

BEHIND = Fault("following_error", "is 0.2 rad from where it should be", axis=1)
FAST = Fault("velocity_limit", "moves at 2.1 rad/s, more than it may", axis=1)


@pytest.fixture(scope="module")
def figures():
    return presumed_figures(ArmBench(250.0).robot)


def sprung(figures):
    stiffness = figures.stiffness.copy()
    stiffness[0] = 1000.0
    return replace(figures, stiffness=stiffness)


def test_who_may_have_met_something_is_not_tried_again(figures):
    assert slower_after(BEHIND, figures, 1.0) is None
    assert slower_after(replace(BEHIND, kind="not_held"), sprung(figures), 1.0) is None
    for fault, known in (
        (FAST, figures),
        (replace(BEHIND, was_there=True), figures),
        (BEHIND, sprung(figures)),
    ):
        assert slower_after(fault, known, 1.0).pace == 2.0


def test_what_is_slow_is_not_made_slower_for_ever(figures):
    assert slower_after(FAST, figures, 0.5 * SLOWEST).pace == SLOWEST
    assert slower_after(FAST, figures, 0.6 * SLOWEST).pace == SLOWEST
    assert slower_after(FAST, figures, SLOWEST) is None


@pytest.mark.long
def test_a_joint_that_came_to_its_limit_turns_less_far_each_time(figures):
    """To be slower alone is no room."""
    out = Fault("position_limit", "would stop at 2.55 rad, beyond its limit", axis=1)
    once = slower_after(out, figures, 1.0)
    assert once.room == (1.0, MORE, 1.0, 1.0, 1.0, 1.0, 1.0)
    assert slower_after(out, figures, 2.0, once).room[1] == MORE**2
    assert slower_after(replace(FAST, axis=3), figures, 2.0, once).room == once.room
    arm = ArmBench(500.0)
    wide = {"kind": "tracking", "parameters": {"joints": [6], "amplitude": 2.84, "period": 30.0}}
    plan = read_request(wide).build(arm.around)
    known = learnt(arm.profile, arm.robot, presumed_figures(arm.robot))
    joints, start = Joints(known.figures, known.gains, ahead=True), plan.start
    shares = []
    for room in ((), (1.0,) * 5 + (MORE, 1.0), (1.0,) * 5 + (MORE**2, 1.0)):
        slower = Slower(2.0, "joint 6 came to its limit", room)
        found = paced(plan, start, arm.robot, arm.limits, arm.rate, joints, slower)
        shares.append(found.adjusted.less_far.get(6, 0.0))
    assert shares[0] < shares[1] < shares[2]


def test_the_next_try_is_no_faster_and_says_why():
    arm = ArmBench(500.0)
    asked = {"kind": "tracking", "parameters": {"joints": [7], "amplitude": 0.3, "period": 4.0}}
    plan = read_request(asked).build(arm.around)
    known = learnt(arm.profile, arm.robot, presumed_figures(arm.robot))
    joints = Joints(known.figures, known.gains, ahead=True)
    start = np.zeros(arm.robot.n)
    free = paced(plan, start, arm.robot, arm.limits, arm.rate, joints)
    slow = paced(plan, start, arm.robot, arm.limits, arm.rate, joints, Slower(2.0, "joint 7 fell"))
    assert free.adjusted.pace < 2.0
    assert slow.adjusted.pace == 2.0
    assert slow.check.sentence.startswith("joint 7 fell: run at 1/2 of the speed")


@pytest.mark.long
def test_an_arm_whose_prediction_is_too_bold_gets_through(tmp_path):
    arm = foreign(724, tmp_path)
    assert arm.first_motion() is None
    entry = STARTING_SET[-1]
    asked = read_request({"kind": entry.kind, "parameters": entry.parameters})
    for one in STARTING_SET[1:-1]:
        other = read_request({"kind": one.kind, "parameters": one.parameters})
        assert arm.run_on(other.build(arm.around))[1] is None
    _, fault = arm.run_on(asked.build(arm.around))
    assert fault is None
    assert any("tried again at 1/" in note for note in arm.notes)
