"""A joint that goes slowly slides as well: its dry friction is given ahead whole."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pa10d.control.gains import PidGains
from pa10d.control.held_friction import CREPT
from pa10d.control.pid import Pid
from pa10d.experiments.shaking import SHARP, sliding

PERIOD = 0.01
DRY, INERTIA, SOFT = 0.49, 0.5, 0.65  # N·m, kg·m², N·m/rad: 0.15 rad of it do not move the joint


def to_and_fro(way, seconds, stands=0.5):
    """(N, 1) each: it stands, goes by ``way`` and back, and stands."""
    pause = np.zeros(round(stands / PERIOD))
    s = np.arange(PERIOD, 1.0 + 1e-9, PERIOD / seconds)
    out, run = 10 * s**3 - 15 * s**4 + 6 * s**5, 30.0 * (s**2 - 2 * s**3 + s**4) / seconds
    q = way * np.concatenate([pause, out, 1.0 - out, pause])
    return q[:, None], (way * np.concatenate([pause, run, -run, pause]))[:, None]


def farthest(q, dq, given):
    """rad that a joint leaves its path by, of a soft servo that is given friction ahead."""
    gains = PidGains(np.array([SOFT]), np.array([0.01]), np.array([0.57]))
    servo, at, speed, worst = Pid(gains, np.array([5.0]), PERIOD), 0.0, 0.0, 0.0
    still = SimpleNamespace(q=q[0], dq=dq[0], extra=np.zeros(1))
    servo.start(still, q[0], dq[0], np.zeros(1))
    for k in range(len(q)):
        wanted = SimpleNamespace(q=q[k], dq=dq[k], extra=given[k])
        free = speed + PERIOD * float(servo.torque(wanted, [at], [speed])[0]) / INERTIA
        speed = float(np.sign(free) * max(abs(free) - PERIOD * DRY / INERTIA, 0.0))
        at += PERIOD * speed
        worst = max(worst, abs(at - float(q[k, 0])))
    return worst


def test_a_soft_servo_keeps_a_joint_that_rubs_on_a_slow_way():
    q, dq = to_and_fro(0.3, 40.0)
    assert np.abs(dq).max() < SHARP, "slow all the way"
    assert farthest(q, dq, DRY * sliding(q, dq)) < 0.01
    assert farthest(q, dq, DRY * np.tanh(dq / SHARP)) > 0.1, "by its speed alone it sticks"


@pytest.mark.parametrize("seconds", [1.0, 40.0])
def test_all_of_it_between_where_joints_stand(seconds):
    q, dq = to_and_fro(0.3, seconds)
    q, dq = np.hstack([q, -0.5 * q]), np.hstack([dq, -0.5 * dq])
    share, half = sliding(q, dq), len(q) // 2
    assert (share[dq == 0.0] == 0.0).all()
    assert (np.sign(share) == np.sign(dq)).all()
    ends = np.abs(q), np.abs(q - q[half - 1])
    far = np.minimum(*ends) > CREPT * (1 + 1e-9)
    assert np.abs(share[far]) == pytest.approx(1.0)
    assert (np.abs(share) >= np.abs(np.tanh(dq / SHARP))).all()
    assert (np.abs(share) <= 1.0).all()
