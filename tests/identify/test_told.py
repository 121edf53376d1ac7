"""Shapes of effects that a user asked for."""

from __future__ import annotations

import numpy as np
import pytest
from test_shift import URDF, pendulum

from pa10d.dynamics import robot_from_urdf
from pa10d.identify import identify
from pa10d.measurement.recording import Recording
from pa10d.model import Term


def told(vs: float, delta: float, v0: float, step: float = 0.0, seed: int = 3) -> Term:
    """Of a pendulum whose friction rises from 2 to 3.2 N·m below vs, by an encoder of such steps
    (rad)."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 60.0, 1 / 200)
    w, a, p = 2 * np.pi * rng.uniform(0.04, 0.4, 5), rng.uniform(0.2, 0.5, 5), rng.uniform(0, 6, 5)
    s = np.outer(t, w) + p
    q, dq, ddq = np.sin(s) @ a, np.cos(s) @ (a * w), -np.sin(s) @ (a * w**2)
    level = 2.0 + 1.2 * np.exp(-((np.abs(dq) / vs) ** delta))
    true = 0.35 * ddq + 7.848 * np.sin(q) + level * np.tanh(dq / v0) + 0.3 * dq
    q = np.round(q / step) * step if step else q
    run = Recording(t=t, q=q[:, None], tau=(true + rng.normal(0, 0.02, len(t)))[:, None], name="r")
    model = identify(
        [run], robot_from_urdf(URDF), name="m", cutoff=10.0, with_effects=("stribeck",)
    )
    (bump,) = [term for term in model.terms if term.effect_id == "stribeck"]
    return bump


@pytest.mark.by_default("0.002")
@pytest.mark.parametrize("v0", [0.0003, 0.002])
def test_reversals_do_not_bend_a_told_bump(v0):
    """What 18 bits a turn make of sharp reversals weighed more than the bump: 0.077 and 0.080."""
    bump = told(0.09, 2.0, v0, 2 * np.pi / 2**18, seed=4)
    assert bump.shape["vs"] == pytest.approx(0.09, rel=0.05)
    assert bump.coefficients[0] == pytest.approx(1.2, rel=0.05)


@pytest.mark.by_default("0.16")
@pytest.mark.parametrize(("vs", "delta", "v0"), [(0.09, 2.0, 0.004), (0.16, 1.4, 0.01)])
def test_a_told_bump_is_fitted_and_knows_its_errors(vs, delta, v0):
    """It stayed at the nearest of its starts, with a standard error of zero."""
    bump = told(vs, delta, v0)
    assert bump.shape["vs"] == pytest.approx(vs, rel=0.05)
    assert bump.shape["delta"] == pytest.approx(delta, rel=0.1)
    for name, value in (("vs", vs), ("delta", delta)):
        error = bump.shape_errors[name]
        assert 0.0 < error < 0.1 * value
        assert abs(bump.shape[name] - value) < 5.0 * error


def test_a_worn_spot_that_was_told_is_no_wave():
    """Its shape was sought as a wave only, from where a wave had looked best at first."""
    rng = np.random.default_rng(3)
    t = np.arange(0, 60.0, 1 / 200)
    w, a, p = 2 * np.pi * rng.uniform(0.04, 0.4, 5), rng.uniform(0.2, 0.5, 5), rng.uniform(0, 6, 5)
    s = np.outer(t, w) + p
    q, dq, ddq = np.sin(s) @ a, np.cos(s) @ (a * w), -np.sin(s) @ (a * w**2)
    level = 2.0 + 0.8 * np.exp(-((q - 0.4) ** 2) / (2 * 0.25**2))
    true = 0.35 * ddq + 7.848 * np.sin(q) + level * np.tanh(dq / 0.01) + 0.3 * dq
    run = Recording(t=t, q=q[:, None], tau=(true + rng.normal(0, 0.02, len(t)))[:, None], name="r")
    model = identify(
        [run], robot_from_urdf(URDF), name="m", cutoff=10.0, with_effects=("position_friction:1",)
    )
    (spot,) = [term for term in model.terms if term.effect_id == "position_friction"]
    assert spot.shape["wave"] == 0
    assert spot.shape["qc"] == pytest.approx(0.4, abs=0.01)
    assert spot.shape["w"] == pytest.approx(0.25, rel=0.03)
    assert spot.coefficients[0] == pytest.approx(0.8, rel=0.03)


def test_a_saturation_that_was_told_has_its_size():
    """Two rounds to its own answer were too few: half as much again."""
    model = identify(
        [pendulum(seed, 1e-3) for seed in (2, 3)],
        robot_from_urdf(URDF),
        name="m",
        cutoff=10.0,
        with_effects=("torque_saturation",),
    )
    (bent,) = [term for term in model.terms if term.effect_id == "torque_saturation"]
    assert bent.coefficients[0] == pytest.approx(1e-3, rel=0.03)
