"""What a creeping joint's integral holds of its friction is let go as its motion brings its own."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pa10d.control.gains import PidGains
from pa10d.control.held_friction import CREPT, LET_GO, SLIPS, HeldFriction
from pa10d.control.pid import Pid

PERIOD = 0.004  # s
COULOMB = np.array([2.0, 0.5])  # N·m
WAITS, MOVES = np.zeros(2, bool), np.ones(2, bool)
SLOW, FAST = np.full(2, 0.5 * SLIPS), np.array([0.5, 2.0]) * SLIPS


def let_go(way, dq=SLOW, coulomb=COULOMB, less=0.0):
    """(2,) N·m in all, of joints that crept ``way`` (2, rows) rad, stand while their torque falls
    by ``less`` (N·m), and then move."""
    held, torque = HeldFriction(coulomb, PERIOD), 10.0 * np.ones(2)
    held.start(np.zeros(2), torque)
    for q in np.transpose(way):
        assert not held.let_go(q, dq, WAITS, torque).any(), "a joint that waits needs what it holds"
    for _ in range(50):
        torque = torque - less / 50
        held.let_go(q, 0.0 * dq, WAITS, torque)
    return sum(held.let_go(q, dq, MOVES, torque) for _ in range(round(20 * LET_GO / PERIOD)))


def test_all_of_it_goes_by_the_way_the_joint_crept():
    way = np.linspace(0.0, 3.0 * CREPT, 50) * np.array([[1.0], [-1.0]])
    assert let_go(way) == pytest.approx(COULOMB * [1.0, -1.0], rel=1e-6)
    assert let_go(0.3 * CREPT * np.ones((2, 1))) == pytest.approx(0.3 * COULOMB, rel=1e-6)


@pytest.mark.parametrize("share", [0.4, 1.0, 1.6])
def test_a_torque_that_fell_while_the_joint_stood_holds_less_of_it(share):
    """Friction balances the torque: what the servo takes back holds none any more."""
    way = np.linspace(0.0, 3.0 * CREPT, 50) * np.array([[1.0], [1.0]])
    assert let_go(way, less=share * COULOMB) == pytest.approx((1.0 - share) * COULOMB, abs=1e-6)


@given(
    way=st.lists(st.tuples(*2 * [st.floats(-5 * CREPT, 5 * CREPT)]), min_size=1, max_size=30),
)
def test_never_more_than_friction(way):
    assert (np.abs(let_go(np.transpose(way))) <= COULOMB * (1 + 1e-9)).all()


def test_a_slip_leaves_nothing_known():
    way = np.linspace(0.0, 3.0 * CREPT, 50) * np.ones((2, 1))
    assert let_go(way, FAST) == pytest.approx([COULOMB[0], 0.0], rel=1e-6)


def test_friction_that_was_not_measured_is_not_let_go():
    assert not HeldFriction(np.zeros(2), PERIOD).known
    way = np.linspace(0.0, 3.0 * CREPT, 50) * np.ones((2, 1))
    assert let_go(way, coulomb=COULOMB * [1.0, 0.0])[1] == 0.0


def worst_of_a_stroke(friction: float, way: float) -> float:
    """rad: a joint creeps upwards to its place and is then sent by ``way``, its friction (2 N·m)
    and inertia brought along; the servo thinks of ``friction``."""
    inertia, dry, wet, place, seconds = 0.5, 2.0, 0.5, 0.02, 1.0
    gains = PidGains(np.array([40.0]), np.array([60.0]), np.array([6.0]))
    gains = PidGains(gains.kp, gains.ki, gains.kd, friction=np.array([friction]))
    servo, q, dq, worst = Pid(gains, np.array([30.0]), PERIOD), 0.0, 0.0, 0.0
    servo._held.start(np.zeros(1), np.zeros(1))
    for k in range(round(8.0 / PERIOD)):
        s = np.clip((k * PERIOD - 6.0) / seconds, 0.0, 1.0)
        run = way * 30.0 * (s**2 - 2 * s**3 + s**4) / seconds
        at = SimpleNamespace(
            q=np.array([place + way * (10 * s**3 - 15 * s**4 + 6 * s**5)]),
            dq=np.array([run]),
            extra=np.array([dry * np.sign(run) + wet * run]),
        )
        wanted = servo.torque(at, np.array([q]), np.array([dq]))
        servo.applied(wanted, wanted)
        torque = float(wanted[0])
        for _ in range(8):
            h = PERIOD / 8
            free = (dq + h * torque / inertia) / (1 + h * wet / inertia)
            stop = h * dry / inertia / (1 + h * wet / inertia)
            dq = float(np.sign(free) * max(abs(free) - stop, 0.0))
            q += h * dq
        if s > 0.0:
            worst = max(worst, abs(q - float(at.q[0])))
    return worst


@pytest.mark.parametrize("way", [0.3, -0.3])
def test_a_stroke_after_a_creep_keeps_to_its_path(way):
    assert worst_of_a_stroke(2.0, way) < 0.75 * worst_of_a_stroke(0.0, way)
