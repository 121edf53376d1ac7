"""What swings is named with its frequency, what acts the wrong way round with its joint."""

from __future__ import annotations

import numpy as np
import pytest
from arms import PERIOD, cycles, flywheel_arm, holding_arm, limits, swing, until

from pa10d.control.faults import LoopFault
from pa10d.control.first_steps import FirstSteps
from pa10d.control.gains import PidGains
from pa10d.control.oscillation import OscillationWatch
from pa10d.control.pid import Pid
from pa10d.control.reference import Reference
from pa10d.control.states import ArmState
from pa10d.control.wrong_way import WrongWayWatch


def seen(speed, torque, asked=lambda t: 0.0, seconds=4.0):
    """The violation that a joint with these speeds and torques brings, or None."""
    watch, reference = OscillationWatch(limits(2), PERIOD), Reference(2)
    for k in range(int(seconds / PERIOD)):
        t = k * PERIOD
        reference.dq[1] = asked(t)
        try:
            watch.watch(np.array([0.0, speed(t)]), reference, np.array([0.0, torque(t)]))
        except LoopFault as violation:
            return violation
    return None


@pytest.mark.parametrize("hertz", [1.0, 7.0, 31.0])
def test_a_swing_is_named_with_joint_and_frequency(hertz):
    w = 2 * np.pi * hertz
    found = seen(lambda t: 0.5 * np.sin(w * t), lambda t: 20 * np.cos(w * t), seconds=8.0)
    assert (found.kind, found.axis) == ("oscillation", 1)
    said = float(found.cause.split("at ")[1].split(" Hz")[0])
    assert said == pytest.approx(hertz, rel=0.1)


def test_what_is_no_swing_is_not_called_one():
    w = 2 * np.pi * 5.0
    small = seen(lambda t: 0.02 * np.sin(w * t), lambda t: 20 * np.cos(w * t))
    fading = seen(lambda t: 0.8 * np.exp(-2 * t) * np.sin(w * t), lambda t: 20 * np.cos(w * t))
    idle = seen(lambda t: 0.5 * np.sin(w * t), lambda t: 0.5 * np.cos(w * t))
    wanted = seen(
        lambda t: 0.8 * np.sin(w * t), lambda t: 20 * np.cos(w * t),
        asked=lambda t: 0.5 * np.sin(w * t - 0.5),
    )  # fmt: skip
    assert (small, fading, idle, wanted) == (None, None, None, None)


def test_a_servo_between_two_counts_of_a_coarse_encoder_does_not_swing():
    """A wrist of 12 bits went to and fro by one of them, and was given calmer gains, with which it
    could follow nothing."""
    w, count = 2 * np.pi * 16.0, 2 * np.pi / 4096
    for counts, swings in ((1.2, False), (4.0, True)):
        watch, reference, found = OscillationWatch(limits(2), PERIOD), Reference(2), -1
        watch.grains = np.full(2, count)
        for k in range(int(3.0 / PERIOD)):
            speed = counts * count * w * np.sin(w * k * PERIOD)
            torque = 20 * np.cos(w * k * PERIOD)
            found = max(
                found, watch.see(np.array([0.0, speed]), reference, np.array([0.0, torque]))
            )
        assert (found == 1) == swings


def test_an_arm_that_swings_is_stopped_softly_and_says_so():
    arm, backend = holding_arm()
    one = np.ones(2)
    arm.use(Pid(PidGains(900 * one, 0 * one, 1.0 * one), limits().torque, PERIOD))
    backend.plant.dq[1] = 0.3
    until(arm, ArmState.FAULT)
    assert (arm.fault.kind, arm.fault.axis) == ("oscillation", 1)
    assert "Hz" in arm.fault.sentence
    assert "first_motion" in arm.fault.sentence
    assert abs(backend.plant.dq[1]) < 0.1


@pytest.mark.parametrize(("grows", "suspected"), [(1.8, True), (1.2, False)])
def test_one_that_grows_fast_is_no_fall_and_no_collision(grows, suspected):
    """Within four halves it is faster than it may be."""
    watch, reference, half = OscillationWatch(limits(2), PERIOD), Reference(2), 5
    for k in range(4 * half):
        sign, size = (-1.0) ** (k // half), grows ** (k / half)
        turning = np.sin(np.pi * (k % half + 0.5) / half)
        speed, torque = 0.2 * sign * size * turning, -20 * sign * turning
        watch.see(np.array([0.0, speed]), reference, np.array([0.0, torque]))
    assert watch.suspected(1) is suspected
    assert not watch.suspected(0)


def test_an_ordinary_motion_is_no_swing():
    arm, _ = holding_arm()
    arm.run(swing(arm.path.reference.q, 0.5, 3.0))
    until(arm, ArmState.HOLDING)
    assert arm.fault is None


def held(push, sign, inertia=1.0, seconds=1.0):
    """A servo holds a joint that ``push`` (t → N·m) pushes; its torque has this sign."""
    watch, stiff, damping = WrongWayWatch(np.array([50.0]), PERIOD), 600.0, 40.0
    q = v = 0.0
    for k in range(int(seconds / PERIOD)):
        torque = -stiff * q - damping * v
        try:
            watch.watch(np.array([q]), np.array([v]), np.array([torque]))
        except LoopFault as violation:
            return violation, q
        v += PERIOD * (sign * torque + push(k * PERIOD)) / inertia
        q += PERIOD * v
    return None, q


@pytest.mark.parametrize("push", [0.05, 2.0, 10.0])
def test_a_wrong_sign_is_seen_within_three_hundredths_of_a_radian(push):
    found, q = held(lambda t: push, -1.0)
    assert found.kind == "wrong_sign"
    assert abs(q) < 0.03


@pytest.mark.parametrize("push", [5.0, 20.0, 45.0])
def test_a_load_that_nobody_knew_is_no_wrong_sign(push):
    assert held(lambda t: push, 1.0)[0] is None
    assert held(lambda t: push * np.sin(20 * t), 1.0)[0] is None


@pytest.mark.parametrize("w", [8.0, 15.0, 30.0])
@pytest.mark.parametrize("grows", [100.0, 1000.0])
def test_nor_is_a_sway_that_grows(w, grows):
    """As of a neighbour's spring: the joint comes back again and again."""
    found, q = held(lambda t: grows * t**2 * np.sin(w * t), 1.0, seconds=1.5)
    assert found is None
    assert abs(q) > 0.1


@pytest.mark.parametrize("falls", [False, True])
def test_a_joint_that_another_takes_along_has_no_wrong_sign(falls):
    """The first one is borne by more than it weighs, or falls and is pushed back by a servo that is
    too weak; the second hangs on it, lightly held."""
    mass = np.array([[2.0, 0.6], [0.6, 0.25]])
    watch = WrongWayWatch(np.array([50.0, 50.0]), PERIOD)
    q, v = np.zeros(2), np.zeros(2)
    for k in range(100):
        torque = -np.array([50.0, 40.0]) * q - np.array([5.0, 1.0]) * v
        more = np.array([min(40.0, 2.0 * k), 0.0])
        torque += 0.0 if falls else more
        watch.watch(q, v, torque)
        v = v + PERIOD * np.linalg.solve(mass, torque + (more if falls else 0.0))
        q = q + PERIOD * v
    assert abs(q[1]) > 0.02


def leaning(watched):
    """An upright joint leans over slowly, against a servo that is weaker than its weight, 50 N·m,
    and a gear that rubs: it is pushed back harder and harder, and goes the faster."""
    q, v = 1.5e-3, 0.0
    while q < 0.14:
        torque = -44.0 * q
        watched(q, v, torque)
        v += PERIOD * (50.0 * q + torque - 2.0 * v) / 0.5
        q += PERIOD * v


def test_nor_has_one_that_leans_over_by_more_than_it_is_pushed_back():
    for leans, named in ((np.array([60.0]), False), (None, True)):
        watch = WrongWayWatch(np.array([50.0]), PERIOD, leans)
        steps = FirstSteps(np.array([50.0]), PERIOD, leans)
        reference = Reference(1)
        steps.watch(np.zeros(1), np.zeros(1), np.zeros(1), reference)

        def stepped(q, v, torque, steps=steps, reference=reference):
            reference.dq[:] = -1e-3
            steps.watch(np.array([q]), np.array([v]), np.array([torque]), reference)

        def held_so(q, v, torque, watch=watch):
            watch.watch(np.array([q]), np.array([v]), np.array([torque]))

        watch.watch(np.zeros(1), np.zeros(1), np.zeros(1))
        for watched in (stepped, held_so):
            if named:
                with pytest.raises(LoopFault, match="wrong way"):
                    leaning(watched)
            else:
                leaning(watched)


def test_nor_has_one_that_slips_in_its_brake_before_it_falls():
    """It stands again before the brake lets go of it, and then falls by what its mount, which is
    wrong by 30 degrees, has not told."""
    watch, q = WrongWayWatch(np.array([209.0]), 0.003), 0.0
    slips = [0.02, 0.04, 0.05, 0.058, 0.055, 0.052, 0.043, 0.035, 0.04, 0.03, 0.008, *[-0.005] * 6]
    for v in [*slips, *np.arange(-0.005, 0.36, 0.021)]:
        watch.watch(np.array([q]), np.array([v]), np.array([-1.2 - 300.0 * q - 33.0 * v]))
        q += 0.003 * v
    assert q > 0.01


def test_gains_come_bumpless_by_command():
    from pa10d.control.commands import Commands

    arm, backend = flywheel_arm()
    one = np.ones(2)

    def servo():
        return Pid(PidGains(100 * one, 0 * one, 20 * one), limits().torque, PERIOD)

    commands = Commands(arm, None, servo)
    gains = PidGains(200 * one, 10 * one, 30 * one, 0 * one).document()
    arm.connect()
    assert commands.carry_out({"id": 1, "do": "gains", "gains": gains})["ok"]
    np.testing.assert_array_equal(arm.path.controller.gains.kp, 200.0)
    np.testing.assert_array_equal(arm.path.make_servo().gains.kd, 30.0)
    assert backend.written == []
    cycles(arm, 2)


def test_an_arm_that_swings_up_as_its_brakes_open_is_not_said_to_fall():
    """No weight is taken from it: the next enabling would begin with one that it does not have."""
    arm, backend = flywheel_arm()
    one = np.ones(2)
    arm.path.make_servo = lambda: Pid(
        PidGains(2500 * one, 0 * one, 0 * one), limits().torque, PERIOD
    )
    arm.path.use(arm.path.make_servo())
    arm.connect()
    cycles(arm, 3)
    arm.enable()
    while backend.switching:
        arm.cycle()
    backend.plant.dq[1] = 0.2
    until(arm, ArmState.FAULT)
    assert (arm.fault.kind, arm.fault.axis) == ("oscillation", 1)
    assert not arm.fault.weighed
    assert "Hz" in arm.fault.sentence
