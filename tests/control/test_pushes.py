"""A joint that sticks is pushed; what brought it loose must not carry it away."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from pa10d.control.estimator import SpeedEstimator
from pa10d.control.gains import PidGains
from pa10d.control.pid import Pid

PERIOD = 0.004  # s
LIMIT = np.array([25.0])  # N·m
LAG = 0.02  # s, of the measured speed
DRY, WET, INERTIA = 2.8, 3.5, 0.05  # an upright arm's first axis: light, and rubbing much


def farthest_after_coming_loose(gains: PidGains) -> float:
    """rad beyond its place, ±0.04 rad in turn, that the joint goes."""
    servo = Pid(gains, LIMIT, PERIOD)
    q, dq, seen, worst = 0.0, 0.0, 0.0, 0.0
    for k in range(round(20.0 / PERIOD)):
        place = 0.04 if k * PERIOD % 8.0 < 4.0 else -0.04
        at = SimpleNamespace(q=np.array([place]), dq=np.zeros(1), extra=np.zeros(1))
        seen += (dq - seen) * PERIOD / LAG
        torque = float(servo.torque(at, np.array([q]), np.array([seen]))[0])
        for _ in range(4):
            h = PERIOD / 4
            free = (dq + h * torque / INERTIA) / (1 + h * WET / INERTIA)
            stop = h * DRY / INERTIA / (1 + h * WET / INERTIA)
            dq = float(np.sign(free) * max(abs(free) - stop, 0.0))
            q += h * dq
        worst = max(worst, abs(q) - 0.04)
    return worst


def test_gains_much_softer_than_friction_let_no_joint_creep_away():
    soft = PidGains(*(np.array([k]) for k in (0.1, 0.013, 0.12)), push=0.12 * LIMIT)
    assert farthest_after_coming_loose(soft) < 0.1, "0.186 rad where a push is never let go"


def test_gains_that_bring_a_joint_back_are_left_alone():
    """Not a torque differs from those of a push that is never let go."""
    stiff = PidGains(*(np.array([k]) for k in (40.0, 60.0, 2.0)), push=0.12 * LIMIT)
    servo = Pid(stiff, LIMIT, PERIOD)
    servo._pushed[:] = 2.0
    assert servo._push(np.array([-0.08]), np.array([0.2]), np.zeros(1, dtype=bool)) == 0.0
    soft = Pid(PidGains(np.array([0.8]), stiff.ki, stiff.kd, stiff.push), LIMIT, PERIOD)
    soft._pushed[:] = 2.0
    assert soft._push(np.array([-0.08]), np.array([0.2]), np.zeros(1, dtype=bool)) < 0.0


def test_a_joint_that_sways_is_not_driven_on():
    """It stands for a moment each time it turns round; a push then feeds the sway."""
    gains = PidGains(*(np.array([k]) for k in (40.0, 0.0, 2.0)), push=0.12 * LIMIT)
    servo = Pid(gains, LIMIT, PERIOD)
    at = SimpleNamespace(q=np.zeros(1), dq=np.zeros(1), extra=np.zeros(1))
    for t in np.arange(0.0, 20.0, PERIOD):
        q, dq = 0.02 + 0.01 * np.sin(2.0 * t), 0.02 * np.cos(2.0 * t)
        servo.torque(at, np.array([q]), np.array([dq]))
    assert servo._pushed[0] == 0.0
    for _ in range(round(1.0 / PERIOD)):
        servo.torque(at, np.array([0.02]), np.zeros(1))
    assert servo._pushed[0] < -0.05 * LIMIT[0], "one that sticks is pushed"


def test_a_light_joint_that_hardly_rubs_is_not_shoved():
    """Of a strong motor: one cycle of a full push was 0.1 rad of its gains."""
    gains = PidGains(*(np.array([k]) for k in (0.02, 0.004, 0.002)), push=0.12 * np.array([2.0]))
    servo, q, dq, seen, worst = Pid(gains, np.array([2.0]), 0.01), 0.01, 0.0, 0.0, 0.0
    at = SimpleNamespace(q=np.zeros(1), dq=np.zeros(1), extra=np.zeros(1))
    servo.start(at, np.array([q]), np.zeros(1), np.zeros(1))  # it stands there, and creeps back
    for _ in range(2000):
        torque = float(servo.torque(at, np.array([q]), np.array([seen]))[0])
        dq += 0.01 * (torque - 1e-3 * dq) / 3e-4
        q += 0.01 * dq
        seen += 0.6 * (dq - seen)
        worst = max(worst, abs(q))
    assert worst < 0.02, "0.11 rad where a push begins with all of its strength"


def test_a_slow_sway_is_pushed_less_each_time_it_crosses_its_place():
    gains = PidGains(*(np.array([k]) for k in (264.0, 0.0, 17.0)), push=0.12 * LIMIT)
    servo, pushes = Pid(gains, LIMIT, PERIOD), []
    at = SimpleNamespace(q=np.zeros(1), dq=np.zeros(1), extra=np.zeros(1))
    for t in np.arange(0.0, 30.0, PERIOD):
        before = servo._pushed[0]
        servo.torque(at, np.array([0.006 * np.sin(2.0 * t)]), np.array([0.012 * np.cos(2.0 * t)]))
        pushes.append(abs(servo._pushed[0] - before))
    assert sum(pushes[len(pushes) // 2 :]) == 0.0
    at.dq = np.full(1, 0.1)  # it is led elsewhere
    servo.torque(at, np.array([0.02]), np.array([0.1]))
    at.dq = np.zeros(1)
    for _ in range(round(1.0 / PERIOD)):
        servo.torque(at, np.array([0.02]), np.zeros(1))
    assert abs(servo._pushed[0]) > 0.03 * LIMIT[0], "one that sticks there is pushed"


def test_steps_of_a_coarse_encoder_are_no_motion():
    """Each of a joint that creeps by a milliradian a second looked like 0.008 rad/s, and it was
    never pushed: "did not move", for it was pressed on by two thirds of its friction."""
    gains = PidGains(*(np.array([k]) for k in (40.0, 0.0, 2.0)), push=0.12 * LIMIT)
    servo, period, step = Pid(gains, LIMIT, 0.005), 0.005, 2.0 * np.pi / 2**17
    speed = SpeedEstimator(1, period)
    at = SimpleNamespace(q=np.array([0.04]), dq=np.zeros(1), extra=np.zeros(1))
    for k in range(200):
        q = np.array([np.floor(1e-3 * k * period / step) * step])
        speed.update(q, np.zeros(1, dtype=np.int64), k * period)
        servo.torque(at, q, speed.dq)
    assert servo._pushed[0] > 0.03 * LIMIT[0]
