"""Gain, saturation and delay of the torque reading."""

from dataclasses import replace

import numpy as np
import pytest
from effect_motions import DT, arm_context, columns, rms

from pa10d.effects import effect

J = 1


def refined(name, context, change, rounds):
    """The coefficient that a fit settles on, columns made anew around it each time."""
    kind, shape = effect(name), {}
    for _ in range(rounds):
        column = kind.columns(context, (J,), shape)[:, 0]
        theta = np.array([column @ change / (column @ column)])
        shape = kind.relinearised(theta, shape)
    return float(theta[0]), rms(change - theta[0] * column)


def test_gain_is_a_share_of_the_whole_torque():
    context = arm_context(seed=21)
    assert columns("torque_gain", context, J)[:, 0] == pytest.approx(context.total[:, J])


@pytest.mark.by_default("0.06")
@pytest.mark.parametrize("strength", [0.02, 0.06, 0.1])
def test_saturation_against_the_roots_of_its_cubic(strength):
    """Measured x with true = x - c3·x³; ``strength`` is c3 times the peak squared."""
    context = arm_context(seed=22)
    true = context.total[:, J]
    c3 = strength / np.max(np.abs(true)) ** 2
    measured = np.array([_root(c3, t) for t in true])
    theta, left = refined("torque_saturation", context, measured - true, rounds=6)
    assert theta == pytest.approx(c3, rel=0.03)
    assert left < 0.02 * rms(measured - true)
    exact = columns("torque_saturation", context, J, at=c3)[:, 0]
    assert exact == pytest.approx(measured**3, rel=1e-6, abs=1e-9)


def _root(c3, true):
    """Real root of c3·x³ - x + true = 0 that is nearest to zero."""
    roots = np.roots([c3, 0.0, -1.0, true])
    real = roots[np.abs(roots.imag) < 1e-9].real
    return real[np.argmin(np.abs(real))]


def test_saturation_beyond_the_turning_point_stays_finite():
    context = arm_context(seed=22)
    c3 = 0.5 / np.max(np.abs(context.total[:, J])) ** 2
    found = columns("torque_saturation", context, J, at=c3)
    assert np.isfinite(found).all()
    assert np.max(np.abs(found)) <= (1 / (3 * c3)) ** 1.5 * (1 + 1e-9)


@pytest.mark.parametrize("delay", [3e-4, 0.004, 0.0151, 0.05])
def test_delay_against_a_torque_known_at_all_times(delay):
    context = arm_context(seed=23)

    def at(t):
        return 30 * np.sin(5 * t) + 8 * np.sin(21 * t + 1) + 3 * np.cos(40 * t)

    total = context.total.copy()
    total[:, J] = at(context.t)
    context = replace(context, total=total)
    change = at(context.t - delay) - at(context.t)
    inner = slice(200, -200)  # the ends are continued by guess
    column = columns("torque_delay", context, J, at=delay)[:, 0]
    assert rms((delay * column - change)[inner]) < 0.01 * rms(change[inner])
    theta, _ = refined("torque_delay", context, change, rounds=3)
    assert theta == pytest.approx(delay, rel=0.01)


@pytest.mark.parametrize("late", [0.004, 0.0151, 0.05])
def test_a_smoothed_torque_against_a_low_pass_known_at_all_times(late):
    context = arm_context(seed=23)
    lines = [(30, 5, 0.0), (8, 21, 1.0), (3, 40, 0.5 * np.pi)]

    def at(t, late):
        turned = [(a / np.hypot(1, w * late), w, p - np.arctan(w * late)) for a, w, p in lines]
        return sum(a * np.sin(w * t + p) for a, w, p in turned)

    total = context.total.copy()
    total[:, J] = at(context.t, 0.0)
    change = at(context.t, late) - total[:, J]
    seen = replace(context, total=total)
    column = columns("torque_delay", seen, J, smoothed=1.0, at=late)[:, 0]
    inner = slice(400, -400)  # the ends are continued by guess
    assert rms((late * column - change)[inner]) < 0.01 * rms(change[inner])
    assert effect("torque_delay").relinearised([late], {"smoothed": 1.0})["smoothed"]


def test_a_small_delay_is_the_slope():
    context = arm_context(seed=24)
    slope = np.gradient(context.total[:, J], DT)
    assert columns("torque_delay", context, J)[:, 0] == pytest.approx(-slope)
