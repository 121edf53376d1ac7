"""Orders read off the residual against the angle; the noise floor against the noise put in."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import butter, sosfreqz
from scipy.stats import chi2
from two_links import CUTOFF, RATE, recordings, state_of

from pa10d.compare import noise_floor, residual_of
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.search import ripple
from pa10d.diagnose.search.ripple import (
    HIGHEST_ORDER,
    LOWEST_ORDER,
    chance_beside_neighbours,
    chance_of_line,
    order_peaks,
)
from pa10d.measurement.signals import Lowpass


@pytest.mark.by_default("0-12.0", "1-50.5")
@pytest.mark.parametrize("order", [12.0, 37.0, 50.5])
@pytest.mark.parametrize("joint", [0, 1])
def test_the_strongest_line_is_at_the_order_of_the_ripple(order, joint):
    def extra(t, q, dq, ddq):
        out = np.zeros_like(q)
        out[:, joint] = 0.2 * np.sin(order * q[:, joint] + 0.4)
        return out

    state = state_of(recordings(1, extra))
    peaks = order_peaks(state.train, state.train_residual(), joint)
    assert peaks[0] == pytest.approx(order, abs=0.6)


@pytest.mark.parametrize("work", [1e9, 1e6])
def test_the_order_of_many_turns_is_found_between_coarse_ones(work, monkeypatch):
    """Thirty turns one way resolve a thirtieth of a cycle per turn; also where only the first of
    them can be afforded at first."""
    monkeypatch.setattr(ripple, "LINES_WORK", work)
    t = np.arange(6000) / 200.0
    q = 2.0 * np.pi * (t + 0.01 * np.sin(2.0 * t))
    left = 0.2 * np.sin(71.69 * q + 0.4) + np.random.default_rng(1).normal(0.0, 0.2, len(t))
    seen = SimpleNamespace(q=q[:, None], dq=np.gradient(q, t)[:, None])
    run = SimpleNamespace(context=seen, lowpass=Lowpass(len(t), 200.0, 90.0))
    turning = SimpleNamespace(robot=SimpleNamespace(prismatic=[False]))
    side = SimpleNamespace(
        runs=[run], contexts=[turning], gathered=lambda parts, _: np.concatenate(parts)
    )
    (peak,) = order_peaks(side, {0: left[:: run.lowpass.factor]}, 0, 1)
    assert peak == pytest.approx(71.69, abs=0.5 * 2.0 * np.pi / np.ptp(q))


@pytest.mark.by_default("12.0")
@pytest.mark.parametrize("order", [12.0, 37.0, 90.0])
def test_a_line_stands_above_its_neighbours(order):
    def extra(t, q, dq, ddq):
        out = np.zeros_like(q)
        out[:, 1] = 0.2 * np.sin(order * q[:, 1] + 0.4)
        return out

    state = state_of(recordings(1, extra))
    left = state.held_residual()
    assert chance_beside_neighbours(state.held, left, 1, order) < 1e-4
    assert chance_beside_neighbours(state.held, left, 1, order + 9.0) > 0.01


@pytest.mark.long
def test_what_is_strong_at_all_orders_has_no_line():
    """Friction that jumps at angles drawn at random: a broad spectrum against the angle, far above
    the noise, of which no order stands out."""
    said = 0
    for seed in range(12):
        places = np.random.default_rng(seed).uniform(-1.5, 1.5, 40)
        sizes = np.random.default_rng(seed + 99).standard_normal(40)

        def extra(t, q, dq, ddq, places=places, sizes=sizes):
            out = np.zeros_like(q)
            out[:, 1] = 0.3 * (np.abs(q[:, 1, None] - places) < 0.02) @ sizes
            return out

        state = state_of(recordings(1, extra))
        (peak,) = order_peaks(state.train, state.train_residual(), 1, 1)
        said += chance_beside_neighbours(state.held, state.held_residual(), 1, peak) < 0.01
    assert said <= 2


def test_a_joint_that_hardly_moves_has_no_orders():
    state = state_of(recordings(1))
    for run in state.train.runs:
        run.context.q[:, 1] = 0.1
    assert order_peaks(state.train, state.train_residual(), 1) == []


@pytest.mark.long
def test_chance_of_a_line_is_how_often_noise_alone_has_one_that_strong():
    """White noise, fitted at each of many orders on its own: how strong the strongest is."""
    state = state_of(recordings(3))
    (run,) = state.train.runs[:1]
    side = Side.of([run])
    q = run.context.q[:: run.lowpass.factor, 1][side.keep[0][:, 1]]
    rng = np.random.default_rng(8)
    noise = rng.standard_normal((len(q), 400))
    strongest = np.zeros(noise.shape[1])
    for order in np.arange(LOWEST_ORDER, HIGHEST_ORDER, 1.0 / np.ptp(q)):
        line = np.linalg.qr(np.column_stack([np.cos(order * q), np.sin(order * q)]))[0]
        strongest = np.maximum(strongest, np.sum((line.T @ noise) ** 2, axis=0))
    for share in (0.2, 0.05):
        power = float(np.quantile(strongest, 1.0 - share))
        assert 0.6 * share < chance_of_line(side, 1, power) < 2.5 * share
        assert chi2.sf(power, 3) < 0.1 * share, "an order is no parameter like others"


def test_noise_floor_is_what_the_low_pass_leaves_of_white_noise():
    sigma = 0.05
    f = np.linspace(0, RATE / 2, 4000)
    sos = butter(4, CUTOFF, fs=RATE, output="sos")
    passed = np.abs(sosfreqz(sos, worN=f, fs=RATE)[1]) ** 4  # there and back
    expected = sigma * np.sqrt(np.mean(passed))
    state = state_of(recordings(6, noise=sigma))
    assert _floor(state) == pytest.approx([expected] * 2, rel=0.1)


def test_a_clean_arm_reaches_its_floor_and_a_hidden_torque_does_not_raise_it():
    clean = state_of(recordings(6))
    residual = clean.held_residual()
    reached = np.array([np.sqrt(np.mean(residual[j] ** 2)) for j in range(2)])
    assert reached / _floor(clean) == pytest.approx([1.0, 1.0], abs=0.1)
    hidden = state_of(
        recordings(6, lambda t, q, dq, ddq: np.column_stack([0 * t, np.sin(2 * q[:, 1])]))
    )
    assert _floor(hidden) == pytest.approx(_floor(clean), rel=0.3)


def _floor(state):
    return noise_floor([residual_of(state.model, run) for run in state.held.runs]).values
