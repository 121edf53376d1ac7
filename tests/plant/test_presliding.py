"""Bristles and slipping springs against their closed forms under slow displacement."""

import numpy as np
import pytest
from plant_robots import bare, driven, turntable

DT = 0.002


def slow_pull(plant, turns):
    """Move slowly through the given angles, linear between them → angle and friction torque."""
    speed = 0.004
    angles, rates = [], []
    for start, end in zip([0.0, *turns[:-1]], turns, strict=True):
        steps = round(abs(end - start) / (speed * DT))
        angles.append(start + (end - start) * np.arange(steps) / steps)
        rates.append(np.full(steps, np.sign(end - start) * speed))
    q, dq = np.concatenate(angles)[:, None], np.concatenate(rates)[:, None]
    plant.reset(np.zeros(1))
    angle, torque = driven(plant, q, dq, DT)
    return angle[:, 0], torque[:, 0]


def lugre(sigma0, sigma1=0.0):
    return {"effect": "presliding_hysteresis", "joint": 1, "sigma0": sigma0, "sigma1": sigma1}


def test_dahl_curve(tmp_path):
    """σ1 = 0 and constant level: F(x) = Fc (1 - exp(-σ0 x / Fc)) from a fresh start."""
    plant = bare(turntable(tmp_path), [lugre(500.0)], coulomb=3.0)
    x, torque = slow_pull(plant, [0.04])
    expected = 3.0 * (1 - np.exp(-500.0 * x / 3.0))
    later = x > 2e-4
    np.testing.assert_allclose(torque[later], expected[later], atol=0.03)


def test_bristles_spring_back_where_dry_friction_would_stick(tmp_path):
    plant = bare(turntable(tmp_path), [lugre(400.0, 20.0)], coulomb=3.0)
    for torque in np.linspace(0, 1, 4000):
        plant.step(np.array([torque]), DT)
    bent = plant.measure()[0][0]
    # Dahl's curve is already bent at a third of Fc: x = -Fc/σ0 · ln(1 - τ/Fc)
    assert bent == pytest.approx(-3.0 / 400.0 * np.log(1 - 1.0 / 3.0), rel=0.01)
    for torque in np.linspace(1, 0, 4000):
        plant.step(np.array([torque]), DT)
    assert abs(plant.measure()[0][0]) < 0.4 * bent


def test_steady_sliding_is_the_stribeck_curve_all_the_same(tmp_path):
    rise = {"effect": "stribeck", "joint": 1, "Fs": 1.5, "vs": 0.08, "delta": 2.0}
    plant = bare(turntable(tmp_path), [lugre(500.0, 5.0), rise], coulomb=3.0, viscous=2.0)
    for speed in (0.05, 0.5, -0.2):
        t = np.arange(0, 3, DT)
        q = (speed * t)[:, None]
        _, torque = driven(plant, q, np.full_like(q, speed), DT)
        size = 3.0 + 1.5 * np.exp(-((speed / 0.08) ** 2)) + 2.0 * abs(speed)
        assert torque[-300:].mean() == pytest.approx(np.sign(speed) * size, rel=2e-3)


def test_slipping_springs_follow_masings_rule(tmp_path):
    """Virgin curve F(x) = Σ W min(x/d, 1); after reversal the same, doubled in both directions."""
    shares, slips = np.array([0.2, 0.3, 0.5]), np.array([0.002, 0.006, 0.012])
    effect = {
        "effect": "presliding_hysteresis",
        "joint": 1,
        "model": "maxwell",
        "shares": shares.tolist(),
        "displacements": slips.tolist(),
    }
    plant = bare(turntable(tmp_path), [effect], coulomb=3.0)

    def virgin(x):
        return 3.0 * np.sum(shares * np.minimum(x[:, None] / slips, 1.0), axis=1)

    x, torque = slow_pull(plant, [0.02, -0.02])
    turn = int(np.argmax(x))
    np.testing.assert_allclose(torque[50 : turn - 50], virgin(x[50 : turn - 50]), atol=0.03)
    back = slice(turn + 100, None)
    expected = torque[turn - 50] - 2.0 * virgin((x[turn] - x[back]) / 2.0)
    np.testing.assert_allclose(torque[back], expected, atol=0.05)


def test_a_closed_loop_of_friction_takes_energy(tmp_path):
    plant = bare(turntable(tmp_path), [lugre(300.0, 2.0)], coulomb=3.0)
    x, torque = slow_pull(plant, [0.02, -0.02, 0.02])
    first, last = int(np.argmax(x[: len(x) // 2])), len(x) - 1
    area = np.trapezoid(torque[first:last], x[first:last])
    assert 0 < area < 4 * 0.02 * 2 * 3.0
