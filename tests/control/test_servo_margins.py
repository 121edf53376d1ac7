"""Gains keep their margins: against the loop itself, cycle by cycle, and against the old rule."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pa10d.control.estimator import SpeedEstimator
from pa10d.control.gains import PidGains
from pa10d.control.pid import Pid
from pa10d.control.reference import Reference
from pa10d.control.servo_design import (
    SENSITIVITY,
    Case,
    JointGains,
    LoopTiming,
    _crossings,
    asked_gains,
    fitting_gains,
    sensitivity,
)


def largest_later(gains: JointGains, case: Case, rate: float) -> float:
    """How far the joint still swings at the end, of 1 at its begin; the loop as it is."""
    period = 1.0 / rate
    one = [np.array([v]) for v in (gains.kp, gains.ki, gains.kd)]
    law, speed = Pid(PidGains(*one), np.array([1e9]), period), SpeedEstimator(1, period)
    rest, angle, sent, fine = Reference(1), 1e-3, np.zeros(1), 20
    sprung = np.isfinite(case.stiffness)
    motor = case.rotor if sprung else case.inertia
    link, rate_link, rate_motor = angle, 0.0, 0.0
    cycles = int(8.0 * rate)
    late = 0.0
    for cycle in range(cycles):
        speed.update(np.array([angle]), np.zeros(1, np.int64), cycle * period)
        wanted = law.torque(rest, np.array([angle]), speed.dq)
        for _ in range(fine):
            h = period / fine
            pull = 0.0
            if sprung:
                mass = case.inertia - case.rotor
                loss = 2.0 * case.damping * np.sqrt(case.stiffness * mass)
                pull = case.stiffness * (angle - link) + loss * (rate_motor - rate_link)
                rate_link += h * (pull + case.gravity * link) / mass
                link += h * rate_link
            falls = 0.0 if sprung else case.gravity * angle
            rate_motor += h * (float(sent[0]) + falls - pull - case.viscous * rate_motor) / motor
            angle += h * rate_motor
        sent = wanted
        if abs(angle) > 1.0:
            return np.inf
        if cycle > 0.9 * cycles:
            late = max(late, abs(angle))
    return late / 1e-3


@pytest.mark.parametrize("roams", [0.2, 1.0, 3.0])
def test_turns_are_those_of_an_angle_that_is_followed_point_by_point(roams):
    """Curves that pass the negative real axis now one way, now the other, some of them often."""
    rng = np.random.default_rng(7)
    steps = rng.standard_normal((400, 120)) + 1j * rng.standard_normal((400, 120))
    curves = 1.0 + roams * np.cumsum(steps, axis=1)
    followed = np.unwrap(np.angle(curves), axis=1)
    ends = np.angle(curves[:, -1]) - np.angle(curves[:, 0])
    turns = _crossings(curves)
    np.testing.assert_allclose(followed[:, -1] - followed[:, 0], ends + 2 * np.pi * turns)
    assert len(np.unique(turns)) >= 4


@settings(max_examples=12, deadline=None)
@given(
    st.floats(-2.0, 1.0), st.floats(0.3, 3.0), st.sampled_from([100.0, 250.0, 500.0]),
    st.sampled_from([None, 3.0, 8.0]),
)  # fmt: skip
def test_gains_that_fit_are_stable_and_calm(size, share, rate, mode):
    """Of any joint, three times heavier or lighter than was thought, with a spring or without."""
    thought, bandwidth = 10.0**size, 2 * np.pi * min(4.0, 0.008 * rate)
    inertia, spring = share * thought, {}
    if mode is not None:  # rotor and link alike swing at ``mode`` times the bandwidth
        spring = {"rotor": 0.5 * inertia, "stiffness": (mode * bandwidth) ** 2 * inertia / 4.0}
    case, timing = Case(inertia, **spring), LoopTiming(1.0 / rate, 1.5 / rate)
    gains = fitting_gains(asked_gains(thought, 0.0, bandwidth), [case], timing)
    assert gains.sensitivity <= SENSITIVITY
    assert largest_later(gains, case, rate) < 0.2


@pytest.mark.parametrize("case", [Case(0.3), Case(1.0), Case(12.0), Case(1.0, 0.0, 0.1, 200.0)])
def test_nyquist_and_the_loop_itself_agree_on_what_is_stable(case):
    timing = LoopTiming(0.002, 0.003)
    gains = asked_gains(1.0, 0.0, 2 * np.pi * 4.0)
    stable = np.isfinite(sensitivity(gains, case, timing))
    assert stable == (largest_later(gains, case, 500.0) < 1.0)


@pytest.mark.parametrize(
    ("case", "share", "stable"),
    [
        (Case(1.0, gravity=300.0), 1.0, True),  # kp is 1895
        (Case(1.0, gravity=300.0), 0.1, False),  # weaker than gravity
        (Case(1.0, gravity=1750.0), 1.0, False),  # ki is too much for what is left
        (Case(1.0, 3.0, 0.2, 400.0, gravity=100.0), 0.2, True),
        (Case(1.0, 3.0, 0.2, 400.0, gravity=300.0), 0.2, False),  # 1200 through the spring
        (Case(1.0, 3.0, 0.2, 90.0, gravity=100.0), 0.2, False),  # no servo helps
    ],
)
def test_a_joint_that_stands_upright_is_held_or_is_said_to_fall(case, share, stable):
    timing = LoopTiming(0.002, 0.003)
    whole = asked_gains(1.0, 0.0, 2 * np.pi * 4.0)
    gains = JointGains(share * whole.kp, share**1.5 * whole.ki, share**0.5 * whole.kd, np.nan)
    assert np.isfinite(sensitivity(gains, case, timing)) == stable
    assert (largest_later(gains, case, 500.0) < 1.0) == stable


def test_the_rule_alone_swings_where_the_urdf_is_three_times_too_heavy():
    """In the lightest pose, that is: gains are made for one and a half times that."""
    case, timing = Case(1.0 / 3.0 / 1.5), LoopTiming(0.002, 0.003)
    asked = asked_gains(1.0, 0.0, 2 * np.pi * 4.0)
    assert largest_later(asked, case, 500.0) > 1.0
    assert largest_later(fitting_gains(asked, [case], timing), case, 500.0) < 0.2


def test_friction_counts_as_damping():
    asked = asked_gains(0.006, 0.5, 30.0)
    assert asked.kd == pytest.approx(3 * 0.006 * 30 - 0.5)
    assert asked_gains(0.006, 5.0, 30.0).kd == 0.0


def test_where_no_stable_gains_hold_a_joint_calm_ones_say_so():
    """A light rotor in a slow loop cannot carry what gravity needs: weak, but no swing."""
    rotor, timing = Case(0.26), LoopTiming(0.01, 0.02)
    asked = asked_gains(3.8, 10.0, 7.8)
    gains = fitting_gains(asked, [rotor, Case(3.8, 5.0, gravity=200.0)], timing)
    assert gains.kp < 200.0
    assert gains.sensitivity == np.inf
    assert sensitivity(gains, rotor, timing) <= SENSITIVITY
    assert largest_later(gains, rotor, 100.0) < 0.5
