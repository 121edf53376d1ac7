"""A stop ends at rest, whatever the servo's bandwidth: neither too early nor never."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from arms import PERIOD, cycles, limits, swing, until
from fake_backend import FakeBackend, Flywheels

from pa10d.control.arm import Arm
from pa10d.control.gains import PidGains
from pa10d.control.journal import Journal
from pa10d.control.pid import Pid
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState
from pa10d.control.stop import DrivesStop


def arm_with_servo(hertz, viscous=0.05, integral=1.0):
    w = 2 * np.pi * hertz * np.ones(2)
    backend = FakeBackend(Flywheels(2, viscous=viscous), PERIOD)
    gains = PidGains(3 * w**2, integral * w**3, 3 * w)
    arm = Arm(
        backend,
        limits(),
        lambda: Pid(gains, limits().torque, PERIOD),
        lambda q: np.zeros(2),
        Journal(Ring.create(2, 256, PERIOD)),
    )
    arm.connect()
    arm.enable()
    until(arm, ArmState.HOLDING)
    return arm, backend


@pytest.mark.by_default("0.4-8.0-0.5", "0.6-6.0-0.25", "1.0-3.0-0.4", "4.0-3.0-0.25", "4.0-3.0-0.5")
@pytest.mark.parametrize("moment", [0.25, 0.4, 0.5])
@pytest.mark.parametrize(("hertz", "seconds"), [(0.4, 8.0), (0.6, 6.0), (1.0, 3.0), (4.0, 3.0)])
def test_a_stop_ends_at_rest(hertz, seconds, moment):
    arm, backend = arm_with_servo(hertz)
    arm.run(swing(arm.path.reference.q, 0.8, seconds))
    cycles(arm, int(seconds * moment / PERIOD))
    assert arm.state == ArmState.RUNNING
    began = arm.path.time
    arm.stop()
    until(arm, ArmState.HOLDING, ArmState.FAULT, seconds=60.0)
    assert arm.state == ArmState.HOLDING, arm.fault.sentence
    omega = 2 * np.pi * hertz
    assert arm.path.time - began < 5.0 + 20.0 / omega
    assert np.abs(backend.plant.dq).max() < 0.05
    stood = backend.plant.q.copy()
    cycles(arm, round(10.0 / omega / PERIOD))
    assert np.abs(backend.plant.q - stood).max() < 0.01


def test_a_fast_arm_with_a_slow_servo_stops_too():
    """At the speed limit: what a stop of a motion that is gone has to brake."""
    arm, _ = arm_with_servo(1.0)
    arm.run(swing(arm.path.reference.q, 1.5, 2.8))
    cycles(arm, 350)
    assert np.abs(arm.path.reference.dq).max() > 0.8 * limits().velocity[0]
    arm.stop()
    until(arm, ArmState.HOLDING, ArmState.FAULT, seconds=20.0)
    assert arm.state == ArmState.HOLDING, arm.fault.sentence


def test_the_bandwidth_is_read_from_the_gains():
    for hertz in (0.5, 2.0, 5.0):
        arm, _ = arm_with_servo(hertz)
        assert arm.path.bandwidth == pytest.approx(2 * np.pi * hertz)


def test_a_fault_is_no_matter_of_minutes_where_the_integral_is_weak():
    """An arm that nobody has measured was held for 80 s after each fault before its brakes closed,
    and whoever was to try it again gave up: "the arm is stopping"."""
    arm, backend = arm_with_servo(2.0, integral=2e-3)
    assert arm.path.bandwidth < 0.05
    arm.run(swing(arm.path.reference.q, 0.8, 3.0))
    cycles(arm, 500)
    began = arm.path.time
    arm.emergency("following_error", "somebody saw it")
    until(arm, ArmState.FAULT, seconds=100.0)
    assert arm.path.time - began < 3.0
    assert not backend.powered
    assert np.abs(backend.plant.dq).max() < 0.05


def test_nor_is_switching_off_an_arm_that_stopped_already():
    arm, _ = arm_with_servo(2.0, integral=2e-3)
    arm.run(swing(arm.path.reference.q, 0.8, 3.0))
    cycles(arm, 500)
    arm.stop()
    cycles(arm, round(3.0 / PERIOD))
    assert arm.state == ArmState.STOPPING
    began = arm.path.time
    arm.disable()
    until(arm, ArmState.INACTIVE, seconds=100.0)
    assert arm.path.time - began < 1.0


def test_an_arm_that_rests_is_held_and_no_stop_is_overdue_by_a_weak_integral():
    arm, _ = arm_with_servo(2.0, integral=2e-3)
    arm.run(swing(arm.path.reference.q, 0.8, 3.0))
    cycles(arm, 500)
    began = arm.path.time
    arm.stop()
    until(arm, ArmState.HOLDING, ArmState.FAULT, seconds=100.0)
    assert arm.state == ArmState.HOLDING, arm.fault.sentence
    assert arm.path.time - began < 10.0


@pytest.mark.parametrize(("driven_on", "shown", "by"), [
    (0.0, False, None), (0.0, True, None), (400.0, False, 30), (400.0, True, 8),
])  # fmt: skip
def test_what_falls_gathers_speed_until_its_drive_brakes_it(driven_on, shown, by):
    """A light joint is over its speed limit before a ramp begins: it is not wired the wrong way.
    One that its drive drives on is: as soon as its drive shows that it brakes, where it does."""
    period, rise = 0.002, 180.0
    speed = np.array([-2.36])
    path = SimpleNamespace(
        limits=replace(limits(1), velocity=np.array([3.0])), bandwidth=20.0, time=0.0, dq=speed,
        rise=np.array([rise]), live=np.ones(1, dtype=bool), age=np.zeros(1),
    )  # fmt: skip
    stop, found = DrivesStop(path, period), []
    for cycle in range(1, 40):
        path.time = cycle * period
        gains = rise if cycle < 5 else (driven_on or -400.0)
        path.dq = np.minimum(path.dq - period * gains, 0.0)
        ramping = np.array([shown and cycle > 1])
        found += [cycle for _ in stop.runs_on(None, ramping)]
    assert found == [] if by is None else len(found) == 1 and found[0] <= by


def test_how_much_faster_a_joint_gets_is_known():
    arm, _ = arm_with_servo(1.0)
    arm.run(swing(arm.path.reference.q, 1.5, 2.8))
    cycles(arm, 100)
    before = np.abs(arm.path.dq)
    cycles(arm, 1)
    assert arm.path.rise == pytest.approx((np.abs(arm.path.dq) - before) / PERIOD)
    assert (arm.path.rise > 0.0).all()
