"""An arm that is only being measured: its way to the plan waits for what sticks, and its strokes
get slower where no gains help; never on and on, and never where it may have met something."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from arm_bench import ArmBench
from hypothesis import given
from hypothesis import strategies as st

from pa10d.control.faults import Fault
from pa10d.control.gains import PUSH, lightly_pressed
from pa10d.control.joint_figures import presumed_figures
from pa10d.experiments.motion import BEHIND, STICKS, softly, whole_motion
from pa10d.services.joints import learnt, slowed
from pa10d.trajectory.kinds import read_request

FELL = Fault("following_error", "is 0.2 rad from where it should be", axis=5)


@pytest.fixture(scope="module")
def arm():
    bench = ArmBench(250.0)
    bench.known = learnt(bench.profile, bench.robot, presumed_figures(bench.robot))
    return bench


@given(bound=st.floats(0.02, 0.5))
def test_a_push_is_as_large_as_friction_before_the_path_has_left(arm, bound):
    seconds = STICKS / PUSH  # until the push is as large
    bounds = np.full(arm.robot.n, bound)
    gone = 0.5 * softly(arm.known.figures, bounds, 0.0 * bounds) * seconds**2
    assert gone == pytest.approx(BEHIND * bounds)


def test_with_friction_known_only_a_fault_makes_the_way_slow(arm):
    bound, away = arm.limits.following_error, np.zeros(arm.robot.n)
    known = replace(arm.known.figures, doubt=np.full(arm.robot.n, 2.0))
    away[0] = 0.3  # where its stroke begins
    assert softly(known, bound, away) is None
    assert softly(arm.known.figures, bound, away) is not None
    away[4] = -0.05  # where a fault left it
    assert softly(known, bound, away) is not None


def test_the_way_waits_and_the_plan_does_not(arm):
    plan = read_request({"kind": "first_motion", "parameters": {"part": "friction"}})
    plan = plan.build(arm.around)
    start = plan.start + 0.2
    usual = whole_motion(plan, start, arm.robot, arm.rate)
    slowly = softly(arm.known.figures, arm.limits.following_error, plan.start - start)
    soft = whole_motion(plan, start, arm.robot, arm.rate, softly=slowly)
    rows = int(STICKS / PUSH * arm.rate)
    begins = int(np.argmax(np.abs(soft.samples.q - start).max(axis=1) > 0))
    for whole, waits in ((usual, False), (soft, True)):
        gone = np.abs(whole.samples.q[begins : begins + rows] - start).max(axis=0)
        assert (gone <= BEHIND * arm.limits.following_error + 1e-9).all() == waits
    for one, other in zip(usual.samples[1:], soft.samples[1:], strict=True):
        assert one[usual.first : usual.last] == pytest.approx(other[soft.first : soft.last])


def test_strokes_of_half_the_speed_last_as_long_and_go_half_as_far(arm):
    ask = {"kind": "first_motion", "parameters": {"part": "response"}}
    usual = read_request(ask).build(arm.around)
    slow = read_request({**ask, "parameters": {"part": "response", "speed": 0.5}}).build(arm.around)
    for one, other in zip(usual.segments, slow.segments, strict=True):
        assert one.label == other.label
        if not one.label.endswith("shaken"):
            continue
        fast, half = one.motion, other.motion
        assert np.abs(half.end - half.start).max() < 0.6 * np.abs(fast.end - fast.start).max()
        assert 0.8 * fast.duration < half.duration <= fast.duration


def test_slower_twice_at_most_and_only_in_strokes(arm):
    def less(part="response", speed=1.0, fault=FELL):
        return slowed(arm.profile, arm.robot, arm.known, fault, part, speed)

    assert (less(), less(speed=0.5), less(speed=0.25)) == (0.5, 0.25, None)
    assert less(part="friction") is None
    assert less(fault=Fault("oscillation", "swings", axis=5, hertz=9.0)) is None


def test_one_that_was_pressed_on_hard_may_have_met_something(arm):
    known = learnt(arm.profile, arm.robot, presumed_figures(arm.robot))
    bound = arm.limits.following_error[5]
    known.gains.kp[5] = 1.1 * PUSH * arm.robot.effort[5] / bound
    assert slowed(arm.profile, arm.robot, known, FELL, "response", 1.0) is None
    known.gains.kp[5] = 0.9 * PUSH * arm.robot.effort[5] / bound
    assert slowed(arm.profile, arm.robot, known, FELL, "response", 1.0) == 0.5


def test_friction_that_has_turned_round_counts_as_what_held_a_joint(arm):
    """An integral that still holds it for the stroke before presses by that much less."""
    bound, axis = 0.2, 5
    gains, robot = arm.known.gains, arm.robot
    pressed = PUSH * robot.effort[axis] + 1.0
    stiff = replace(gains, kp=np.full(robot.n, pressed / bound))
    figures = arm.known.figures
    for coulomb, lightly in ((0.0, False), (0.4, False), (0.6, True)):
        measured = replace(figures, coulomb=np.full(robot.n, coulomb))
        assert lightly_pressed(robot, measured, stiff, bound, axis) == lightly
