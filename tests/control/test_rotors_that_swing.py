"""A light rotor swings on its spring as its brake opens, and its speed tells no weight."""

from __future__ import annotations

import numpy as np
import pytest

from backends.protocol import Feedback
from pa10d.control.fall import swinging
from pa10d.control.gains import PidGains
from pa10d.control.limits import ArmLimits
from pa10d.control.pid import Pid
from pa10d.control.states import ArmState
from pa10d.control.torque_path import TorquePath
from pa10d.control.trials import TRIALS

PERIOD, FINE = 0.01, 1e-4
LINK, ROTOR, STIFFNESS, LOSS, RUBS = 6e-3, 6e-5, 13.0, 5e-3, 6e-3  # a wrist; 74 Hz of its rotor
AT_MOST = np.array([3.0])
LIMITS = ArmLimits(-AT_MOST, AT_MOST, AT_MOST, 3 * AT_MOST, AT_MOST, 50 * AT_MOST, 0.05 * AT_MOST)


class Wrist:
    """Link and rotor, in a brake until it opens."""

    def __init__(self, weight):
        self.weight = weight
        self.q, self.v = np.array([-weight / STIFFNESS, 0.0]), np.zeros(2)

    def step(self, torque):
        for _ in range(round(PERIOD / FINE)):
            pull = STIFFNESS * (self.q[1] - self.q[0]) + LOSS * (self.v[1] - self.v[0])
            self.v[0] += FINE * (pull - self.weight) / LINK
            own = self.v[1] + FINE * (torque - pull) / ROTOR
            self.v[1] = np.sign(own) * max(abs(own) - FINE * RUBS / ROTOR, 0.0)
            self.q += FINE * self.v


def path_for(presumed):
    gains = PidGains(kp=np.array([1.1]), ki=np.array([0.17]), kd=np.array([0.046]))
    body = np.array([presumed])
    servo = lambda: Pid(gains, LIMITS.torque, PERIOD)  # noqa: E731
    return TorquePath(LIMITS, PERIOD, servo, inertia=(body, body))


def seen(path, wrist, time):
    word = np.zeros(1, dtype=np.int64)
    path.measure(Feedback(time, wrist.q[1:].copy(), np.zeros(1), word, word))


def falls(path, wrist, time):
    """→ s, and whether its brake is to end that. Torque is there before the brake opens."""
    for cycle in range(60):
        seen(path, wrist, time)
        if path.brakes.try_alone([0] if cycle > 3 else [], lambda: np.zeros(1)):
            return time, True
        path.watch_standing()
        torque = float(path.torque(ArmState.ENABLING)[0])
        if cycle > 3:
            wrist.step(torque)
        time += PERIOD
    return time, False


@pytest.mark.parametrize("off", [0.4, 0.6, 1.6])
@pytest.mark.parametrize("presumed", [0.4, 1.0, 2.5])
def test_its_weight_is_found_in_some_trials(off, presumed):
    """N·m: of a link that weighs 0.4, of which so many times that is thought."""
    path, weight, time = path_for(presumed * LINK), 0.4, 0.0
    wrist = Wrist(weight)
    seen(path, wrist, time)
    path.power_up(np.array([off * weight]))
    for _ in range(TRIALS):
        time, again = falls(path, wrist, time + PERIOD)
        if not again:
            break
        place, wrist = wrist.q[1], Wrist(weight)  # its brake has caught it; it has come to rest
        wrist.q += place
    assert not again
    assert abs(wrist.v).max() < 0.5


def test_one_way_only_is_no_swing():
    time = PERIOD * np.arange(6)
    sent = np.ones(6)
    assert swinging(time, -(time**2), sent) is None
    back = np.array([0.0, -0.02, -0.02, -0.01, -0.015, -0.012])
    assert swinging(time, back, sent) is None, "it is not going away"


def test_how_far_and_by_when_tells_how_it_falls():
    time = PERIOD * np.arange(9)
    way = -0.5 * 20.0 * time**2 + 0.004 * np.sin(2 * np.pi * 25.0 * time)
    fell = swinging(time, way, np.append(np.full(8, 0.3), 9.0))
    assert fell.torque == pytest.approx(0.3), "the last one acts from now on"
    assert fell.rise == pytest.approx(-20.0, rel=0.3)


def test_a_joint_that_its_servo_brings_to_rest_does_not_swing():
    """One count of its encoder back is no turn."""
    time = PERIOD * np.arange(60)
    way = 0.05 * (1.0 - np.exp(-time / 0.1)) - 8e-6 * (np.arange(60) == 58)
    assert swinging(time, way, np.ones(60)) is None
