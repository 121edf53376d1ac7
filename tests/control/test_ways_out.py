"""What is told of a joint that no gains hold is true: what it names would help."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from arm_bench import ArmBench

from pa10d.control.faults import Fault
from pa10d.control.joint_figures import first_figures
from pa10d.control.limits import arm_limits
from pa10d.control.servo_design import SENSITIVITY
from pa10d.services.joints import calmed, firmed, learnt
from pa10d.services.ways_out import ways_out

RATE, AXIS = 100.0, 6


def fell(was_there=True):
    return Fault("following_error", "is 0.2 rad from where it should be", AXIS, was_there=was_there)


def swung(hertz):
    return Fault("oscillation", f"swings at {hertz:g} Hz", AXIS, hertz=hertz)


@pytest.fixture(scope="module")
def arm():
    bench = ArmBench(RATE)
    figures = first_figures(bench.robot, [np.zeros(7)] * 2).but(doubt=np.full(7, 4.0))
    return bench.profile, bench.robot, learnt(bench.profile, bench.robot, figures)


@pytest.fixture(scope="module")
def firmest(arm):
    profile, robot, known = arm
    while (more := firmed(profile, robot, known, fell())) is not None:
        known = more.known
    return profile, robot, known


def at(profile, rate):
    return profile.model_copy(update={"control": profile.control.model_copy(update=rate)})


def test_a_rate_is_named_at_which_the_servo_is_firmer_and_all_joints_have_margins(arm, firmest):
    profile, robot, known = firmest
    said = ways_out(profile, robot, known, fell())
    assert said.startswith("its servo is as firm as it can be at 100 Hz without shaking it: raise ")
    rate = float(said.split("raise control.rate to ")[1].split(" Hz")[0])
    faster = learnt(at(profile, {"rate": rate}), robot, known.figures)
    assert faster.gains.kp[AXIS] > known.gains.kp[AXIS]
    wholly = learnt(at(profile, {"rate": rate}), robot, known.figures.but(lighter=np.zeros(0)))
    assert wholly.sensitivity.max() <= SENSITIVITY, "the next joint would fall behind there"
    assert arm[2].sensitivity.max() > SENSITIVITY
    assert "the URDF's masses" in said
    assert "a brake or a collision" in said


def test_none_is_named_that_the_bus_does_not_carry(firmest):
    profile, robot, known = firmest
    bus = profile.can.model_copy(update={"bitrate": 200_000})
    said = ways_out(profile.model_copy(update={"can": bus}), robot, known, fell())
    assert "control.rate" not in said
    assert said.startswith("its servo is as firm as it can be at any rate that this bus carries: ")


def test_a_joint_that_was_pressed_hard_may_be_held_and_gains_are_no_matter(arm):
    profile, robot, known = arm
    strong = replace(known, gains=replace(known.gains, kp=known.gains.kp * 100.0))
    said = ways_out(profile, robot, strong, fell(was_there=False))
    assert "firm" not in said
    assert "control.rate" not in said
    assert "a brake or a collision" in said


def test_no_more_is_said_to_have_pressed_than_the_joint_may_give(arm):
    """A limit that was set too low: 22 N·m were told of a joint that may give 1."""
    profile, robot, known = arm
    effort = robot.effort.copy()
    hard = replace(known, gains=replace(known.gains, kp=known.gains.kp * 100.0))
    pressed = float(hard.gains.kp[AXIS] * arm_limits(profile, robot).following_error[AXIS])
    effort[AXIS] = 0.5 * pressed
    said = ways_out(profile, replace(robot, effort=effort), hard, fell(was_there=False))
    assert said.startswith(f"all that it may give, the {effort[AXIS]:.3g} N·m of limits.torque, ")
    effort[AXIS] = 1.1 * pressed
    said = ways_out(profile, replace(robot, effort=effort), hard, fell(was_there=False))
    assert said.startswith(f"its servo pressed on with {pressed:.3g} N·m, ")


def test_what_was_tried_in_vain_is_said_as_that(arm):
    """Five tries were spent, and a firmer servo there was."""
    said = ways_out(*arm, fell())
    assert "as firm as it can be" not in said
    assert said.startswith("firmer gains were set each time and did not do: correct ")
    assert calmed(*arm, AXIS, 20.0) is not None
    said = ways_out(*arm, swung(20.0))
    assert "set control.bandwidth_hz to " in said
    assert "control.rate" not in said


def test_a_swing_that_no_rate_would_end_is_told_without_one(arm):
    """Of no mass that gains could be made for."""
    profile, robot, known = arm
    assert calmed(profile, robot, known, AXIS, 0.05) is None
    said = ways_out(profile, robot, known, swung(0.05))
    assert said.startswith("calmer gains do not end that: look at this joint's encoder")
