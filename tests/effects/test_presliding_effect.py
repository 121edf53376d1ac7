"""The bristle state against an ODE solver, its closed limit cycle, and what makes it hysteresis."""

import numpy as np
import pytest
from effect_motions import DT, alone, columns, rms
from scipy.integrate import solve_ivp

TWO = np.array([0.3, 0.1]), np.array([1.3, 3.1]), np.array([0.0, 1.0])


def path(t, derivative=0):
    """Two sines with reversals at odd times."""
    size, omega, phase = TWO
    angle = np.outer(np.atleast_1d(t), omega) + phase
    return (size * omega**derivative * np.sin(angle + derivative * np.pi / 2)).sum(axis=1)


def states(t, zs, joint=1):
    context = alone(joint, path(t), path(t, 1), path(t, 2))
    return columns("presliding_hysteresis", context, joint, zs=zs)[:, 0]


@pytest.mark.parametrize("zs", [5e-4, 5e-3, 0.05])
def test_against_an_ode_solver(zs):
    t = np.arange(0.0, 6.0, DT)

    def dahl(s, z):
        v = path(s, 1)[0]
        return v * (1.0 - z * np.sign(v)) / zs

    exact = solve_ivp(
        dahl, (0, t[-1]), [0.0], t_eval=t, method="LSODA", rtol=1e-8, atol=1e-10, max_step=DT
    )
    error = states(t, zs) - exact.y[0]
    assert rms(error) < 3e-4
    assert np.max(np.abs(error)) < 5e-3  # at a reversal, which falls between two samples


@pytest.mark.parametrize(("zs", "lag"), [(5e-3, 0.01), (0.05, 0.1)])
def test_damped_bristles_against_an_ode_solver(zs, lag):
    """LuGre's σ0·z + σ1·dz/dt, of a friction of 1 N·m; z in rad, as it is written there."""
    t = np.arange(0.0, 6.0, DT)
    sigma0, sigma1 = 1.0 / zs, lag / zs

    def rate(s, z):
        v = path(s, 1)[0]
        return v - sigma0 * abs(v) * z

    exact = solve_ivp(
        rate, (0, t[-1]), [0.0], t_eval=t, method="LSODA", rtol=1e-8, atol=1e-12, max_step=DT
    )
    z = exact.y[0]
    moving = np.array([float(rate(s, at)) for s, at in zip(t, z, strict=True)])
    expected = sigma0 * z + sigma1 * moving
    context = alone(1, path(t), path(t, 1), path(t, 2))
    found = columns("presliding_hysteresis", context, 1, zs=zs, lag=lag)[:, 0]
    assert rms(sigma1 * moving) > 0.04  # so that it would be missed
    assert rms(found - expected) < 1e-3


@pytest.mark.parametrize("travel", [0.002, 0.01, 0.06])
def test_steady_loop_ends_at_its_closed_form(travel):
    """Going to and fro over ``travel``, z swings between ±tanh(travel/2zs)."""
    t = np.arange(0.0, 30.0, DT)
    q = 0.5 * travel * np.cos(2 * np.pi * t)
    zs = 0.008
    found = columns("presliding_hysteresis", alone(0, q, q, q), 0, zs=zs)[:, 0]
    last = found[-1000:]
    assert np.max(last) == pytest.approx(np.tanh(travel / (2 * zs)), rel=1e-3)
    assert np.min(last) == pytest.approx(-np.tanh(travel / (2 * zs)), rel=1e-3)


def test_it_follows_the_distance_and_not_the_time():
    """The same path, run slowly: the same state at the same place."""
    fast = states(np.arange(0.0, 6.0, DT), 0.01)
    slow = states(np.arange(0.0, 6.0, DT / 5), 0.01)
    assert slow[::5] == pytest.approx(fast, abs=1e-3)


def test_standing_still_keeps_the_state():
    q = np.concatenate([np.linspace(0, 0.004, 100), np.full(500, 0.004)])
    found = columns("presliding_hysteresis", alone(0, q, q, q), 0, zs=0.01)[:, 0]
    assert found[99:] == pytest.approx(1 - np.exp(-0.4))


def test_a_short_bristle_is_coulomb_friction():
    t = np.arange(0.0, 6.0, DT)
    context = alone(1, path(t), path(t, 1), path(t, 2))
    bristle = columns("presliding_hysteresis", context, 1, zs=1e-4)[:, 0]
    sign = columns("coulomb", context, 1, v0=1e-4)[:, 0]
    far = np.abs(context.dq[:, 1]) > 0.05
    far[0] = False  # it starts unbent
    assert bristle[far] == pytest.approx(sign[far], abs=0.01)
