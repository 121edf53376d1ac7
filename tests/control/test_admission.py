"""What may command the arm: models of this arm that hold it, motions that it can follow."""

from __future__ import annotations

import numpy as np
import pytest
from arms import PERIOD, holding_arm, limits, swing, until
from fake_backend import FakeBackend

from backends.virtual.plant import build
from pa10d.control.build import build_arm, servo_factory
from pa10d.control.commands import Commands
from pa10d.control.live_model import LiveEffect, LiveModel, kinematics_of
from pa10d.control.motion_check import wrong_with_rows
from pa10d.control.reference import MotionUnderWay
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState, Refused
from pa10d.dynamics import robot_from_profile
from pa10d.profile import load_profile

BENT = np.array([0.0, 0.5, 0.0, 0.8, 0.0, 0.3, 0.0])
EVERY = tuple(range(7))


@pytest.fixture(scope="module")
def robot():
    return robot_from_profile(load_profile("pa10-sim"))


@pytest.fixture
def held(robot):
    """The arm behind ideal drives, held in a bent pose, and what takes its commands."""
    profile = load_profile("pa10-sim")
    plant = build(profile)
    plant.reset(BENT)
    arm = build_arm(profile, robot, FakeBackend(plant), Ring.create(7, 256, PERIOD))
    commands = Commands(arm, robot, servo_factory(profile, robot, PERIOD))
    arm.connect()
    arm.enable()
    until(arm, ArmState.HOLDING)
    for _ in range(500):
        arm.cycle()
    return arm, commands


def model_of(robot, **changes):
    friction = LiveEffect("coulomb", EVERY, np.full((7, 1), 1.0), {"v0": np.full(7, 0.01)})
    usual = {"rigid": robot.parameters, "parts": (friction,), "kinematics": kinematics_of(robot)}
    return LiveModel("m", **(usual | changes))


def load(commands, model):
    message = {"id": 1, "do": "controller", "name": "computed_torque", "model": model.document()}
    return commands.carry_out(message)


@pytest.mark.long
def test_the_right_model_is_taken_without_a_step(robot, held):
    arm, commands = held
    before, stood = arm.path.sent.copy(), arm.path.q.copy()
    assert load(commands, model_of(robot)) == {"reply": 1, "ok": True, "state": "holding"}
    arm.cycle()
    assert np.abs(arm.path.sent - before).max() < 0.02 * arm.path.limits.torque.max()
    for _ in range(500):
        arm.cycle()
    assert np.abs(arm.path.q - stood).max() < 1e-3


def with_part(robot, coefficient=1.0, v0=0.01):
    part = LiveEffect("coulomb", EVERY, np.full((7, 1), coefficient), {"v0": np.full(7, v0)})
    return model_of(robot, parts=(part,))


def moved(kinematics):
    out = kinematics.copy()
    out[3, 12] += 0.01
    return out


WRONG = {
    "ten times as heavy": (lambda r: model_of(r, rigid=10.0 * r.parameters), "N·m to hold the arm"),
    "not a number": (lambda r: model_of(r, rigid=np.nan * r.parameters), "is not a number"),
    "friction not a number": (lambda r: with_part(r, np.nan), "coulomb is not a number"),
    "v0 of zero": (lambda r: with_part(r, v0=0.0), "v0 of coulomb: found 0, expected .* above 0"),
    "negative v0": (lambda r: with_part(r, v0=-0.01), "expected a number above 0"),
    "an arm without weight": (lambda r: model_of(r, rigid=0.0 * r.parameters), "do hold it"),
    "upside down": (lambda r: model_of(r, rigid=-r.parameters), "do hold it"),
    "friction that drives": (
        lambda r: with_part(r, -60.0),
        r"joint 1: the model's friction drives: it is -60 N·m against a motion at .* one that brak",
    ),
    "viscous friction that drives": (
        lambda r: model_of(
            r, parts=(*with_part(r).parts, LiveEffect("viscous", (2,), np.array([[-20.0]]), {}))
        ),
        r"joint 3: the model's friction drives: it is -39 N·m against a motion at 2 rad/s",
    ),
    "rotors that drive": (
        lambda r: model_of(
            r, parts=(LiveEffect("rotor_inertia", EVERY, np.full((7, 1), -20.0), {}),)
        ),
        r"joint 1: the model's inertia drives: it wants -\S+ N·m to accelerate by 3 rad/s², expect",
    ),
    "bodies that drive": (
        lambda r: model_of(r, rigid=r.parameters * np.repeat([1.0, -10.0], [4, 6])),
        "the model's inertia drives",
    ),
    "another arm": (
        lambda r: model_of(r, kinematics=moved(kinematics_of(r))),
        "of another arm: its joint 4",
    ),
    "fewer joints": (
        lambda r: model_of(r, kinematics=kinematics_of(r)[:6]),
        "an arm with 6 joints, this has 7",
    ),
    "no arm": (lambda r: model_of(r, kinematics=None), "does not say which arm"),
    "an offset": (
        lambda r: model_of(r, parts=(LiveEffect("torque_offset", (1,), np.array([[60.0]]), {}),)),
        "joint 2: the model wants",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_model_moves_nothing(robot, held, case):
    arm, commands = held
    make, says = WRONG[case]
    before, stood = arm.path.controller, arm.path.q.copy()
    answer = load(commands, make(robot))
    assert not answer["ok"]
    assert "\n" not in answer["detail"]
    with pytest.raises(AssertionError, match=says):
        raise AssertionError(answer["detail"])
    assert arm.path.controller is before
    for _ in range(200):
        arm.cycle()
    assert arm.state == ArmState.HOLDING
    assert np.abs(arm.path.q - stood).max() < 1e-3


def test_friction_that_noise_made_a_little_negative_is_taken(robot, held):
    """… and so is a slope that falls where all friction of the joint still brakes."""
    _, commands = held
    assert load(commands, with_part(robot, -0.05))["ok"]
    falling = LiveEffect("viscous", (2,), np.array([[-0.4]]), {})
    assert load(commands, model_of(robot, parts=(*with_part(robot).parts, falling)))["ok"]


def test_a_model_that_was_loaded_before_power_is_looked_at_when_power_comes(robot, held):
    arm, commands = held
    arm.disable()
    until(arm, ArmState.INACTIVE)
    assert "do hold it" in load(commands, model_of(robot, rigid=0.0 * robot.parameters))["detail"]
    assert load(commands, model_of(robot))["ok"]
    arm.enable()
    until(arm, ArmState.HOLDING)


def test_a_model_that_asks_too_much_along_a_plan_is_refused(robot, held):
    """It holds the arm well, and its rotors weigh a ton."""
    arm, commands = held
    rotors = LiveEffect("rotor_inertia", EVERY, np.full((7, 1), 1e4), {})
    assert load(commands, model_of(robot, parts=(rotors,)))["ok"]
    with pytest.raises(Refused, match=r"joint \d at .* the model wants .* its limit is"):
        arm.run(swing(arm.path.reference.q, amplitude=0.1, seconds=2.0))
    assert arm.state == ArmState.HOLDING


def test_a_model_that_does_not_know_of_a_load_starts_no_motion(robot, held):
    """It held the arm when it was loaded; then something heavy was hung on."""
    arm, commands = held
    write, load_there = arm.backend.write, np.zeros(7)
    arm.backend.write = lambda torque: write(torque - load_there)
    assert load(commands, model_of(robot))["ok"]
    for _ in range(2000):
        load_there[1] = min(load_there[1] + 0.1, 40.0)
        arm.cycle()
    assert arm.state == ArmState.HOLDING
    with pytest.raises(Refused, match=r"joint 2: the model wants .* do hold it"):
        arm.run(swing(arm.path.reference.q, amplitude=0.1, seconds=2.0))
    load_there[1] = 0.0
    for _ in range(2000):
        arm.cycle()
    arm.run(swing(arm.path.reference.q, amplitude=0.1, seconds=2.0))


def spoilt(column, value, row=700):
    def spoil(rows):
        rows[row, column] = value

    return spoil


def shifted(rows):
    rows[700:, 1] += 0.01


def kicked(rows):
    rows[700, 2] = -rows[700, 2]


BAD_ROWS = {
    "nan": (spoilt(0, np.nan), r"joint 1 at 1\.400 s \(row 700\) holds nan, expected a number"),
    "infinite torque": (spoilt(7, np.inf), r"joint 2 at .* holds inf"),
    "far": (spoilt(1, 2.5), r"joint 2 at .* would stop at .* upper limit of 2 rad"),
    "fast": (spoilt(3, 2.1), r"joint 2 at .* moves at 2\.1 rad/s, its limit is 2 rad/s"),
    "hard": (spoilt(4, -4.1), r"joint 1 at .* accelerates with -4\.1 rad/s²"),
    "torque": (spoilt(6, 110.0), r"joint 1 at .* brings 110 N·m along, allowed are 100 N·m"),
    "a jump": (shifted, r"joint 2 at 1\.400 s .* jumps by 0\.01 rad"),
    "a kick": (kicked, r"joint 1 at .* (jumps|changes its speed)"),
}


@pytest.mark.parametrize("case", BAD_ROWS)
def test_a_bad_row_is_named_and_nothing_moves(case):
    arm, _ = holding_arm()
    good = swing(arm.path.reference.q)
    spoil, says = BAD_ROWS[case]
    rows = good.rows.copy()
    spoil(rows)
    with pytest.raises(Refused, match=says):
        arm.run(MotionUnderWay(1, rows))
    assert arm.state == ArmState.HOLDING
    arm.run(good)


@pytest.mark.parametrize("shape", [(0, 8), (10, 7), (10,)])
def test_what_is_no_motion(shape):
    says = wrong_with_rows(np.zeros(shape), 0, 0, np.zeros(2), limits(), PERIOD)
    assert "expected (N, 8)" in says


def test_a_motion_that_does_not_begin_or_end_at_rest():
    rows = swing(np.zeros(2)).rows
    for cut, word in ((rows[500:], "begins"), (rows[:500], "ends")):
        says = wrong_with_rows(cut, 0, len(cut), cut[0, :2], limits(), PERIOD)
        assert f"joint 1: the motion {word} at" in says


def test_the_swing_of_these_tests_is_fine():
    rows = swing(np.zeros(2)).rows
    assert wrong_with_rows(rows, 0, len(rows), np.zeros(2), limits(), PERIOD) is None
