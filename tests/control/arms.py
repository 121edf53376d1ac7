"""Small arms in this process for tests of the loop."""

from __future__ import annotations

import numpy as np
from fake_backend import FakeBackend, Flywheels

from pa10d.control.arm import Arm
from pa10d.control.gains import PidGains
from pa10d.control.journal import Journal
from pa10d.control.limits import ArmLimits
from pa10d.control.outside import SLOW
from pa10d.control.pid import Pid
from pa10d.control.reference import MotionUnderWay
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState

PERIOD = 0.002


def limits(n: int = 2) -> ArmLimits:
    one = np.ones(n)
    return ArmLimits(
        lower=-2.0 * one,
        upper=2.0 * one,
        velocity=2.0 * one,
        acceleration=4.0 * one,
        torque=50.0 * one,
        torque_rate=5000.0 * one,
        following_error=0.1 * one,
    )


def servo(n: int = 2) -> Pid:
    w = 2 * np.pi * 4.0 * np.ones(n)
    return Pid(PidGains(3 * w**2, w**3, 3 * w), limits(n).torque, PERIOD)


def flywheel_arm(
    n: int = 2, capacity: int = 4096, drives: type[FakeBackend] = FakeBackend
) -> tuple[Arm, FakeBackend]:
    backend = drives(Flywheels(n), PERIOD)
    ring = Ring.create(n, capacity, PERIOD)
    arm = Arm(backend, limits(n), lambda: servo(n), lambda q: np.zeros(n), Journal(ring), rests=0.0)
    return arm, backend


def holding_arm(n: int = 2) -> tuple[Arm, FakeBackend]:
    arm, backend = flywheel_arm(n)
    arm.connect()
    cycles(arm, 3)
    arm.enable()
    until(arm, ArmState.HOLDING)
    return arm, backend


def cycles(arm: Arm, count: int) -> None:
    for _ in range(count):
        arm.cycle()


def until(arm: Arm, *states: ArmState, seconds: float = 10.0) -> None:
    """Cycle until one of the states is reached."""
    for _ in range(int(seconds / PERIOD)):
        if arm.state in states:
            return
        arm.cycle()
    raise AssertionError(f"still {arm.state.label} after {seconds} s")


def swing(start: np.ndarray, amplitude: float = 0.8, seconds: float = 3.0) -> MotionUnderWay:
    """All joints out and back, at rest at both ends."""
    t = np.arange(int(seconds / PERIOD)) * PERIOD
    w = 2 * np.pi / seconds
    one = np.ones((1, len(start)))
    q = start + amplitude * one * ((1 - np.cos(w * t)) / 2)[:, None]
    dq = amplitude * one * (w * np.sin(w * t) / 2)[:, None]
    ddq = amplitude * one * (w * w * np.cos(w * t) / 2)[:, None]
    return MotionUnderWay(1, np.hstack([q, dq, ddq, 0 * q]))


def way_in(start, end, share: float = 0.9) -> MotionUnderWay:
    """From rest to rest, the fastest joint at this share of the speed allowed outside."""
    start, span = np.array(start), np.array(end) - np.array(start)
    seconds = max(0.3, 1.875 * np.abs(span).max() / (share * SLOW * limits().velocity[0]))
    s = np.append(np.arange(0.0, seconds, PERIOD) / seconds, 1.0)[:, None]
    q = start + span * (10 * s**3 - 15 * s**4 + 6 * s**5)
    dq = span * (30 * s**2 - 60 * s**3 + 30 * s**4) / seconds
    ddq = span * (60 * s - 180 * s**2 + 120 * s**3) / seconds**2
    return MotionUnderWay(1, np.hstack([q, dq, ddq, 0 * q]))
