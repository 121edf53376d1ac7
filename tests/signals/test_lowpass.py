"""Filtering against scipy, and the laws both sides of an equation rely on."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.signal
from hypothesis import given, settings
from hypothesis import strategies as st

from pa10d.common.errors import UserError
from pa10d.measurement.signals import Lowpass, delayed

RATE = 500.0


def noise(samples=2000, columns=3, seed=0):
    return np.random.default_rng(seed).normal(size=(samples, columns))


def tone(frequency, samples=2000, rate=RATE):
    return np.sin(2 * np.pi * frequency * np.arange(samples) / rate + 0.4)


@pytest.mark.parametrize("cutoff", [5.0, 20.0, 60.0])
def test_equals_forward_backward_butterworth_away_from_the_ends(cutoff):
    x = noise()
    sos = scipy.signal.butter(4, cutoff, fs=RATE, output="sos")
    theirs = scipy.signal.sosfiltfilt(sos, x, axis=0)
    ours = Lowpass(len(x), RATE, cutoff)(x)
    inner = slice(600, -600)
    np.testing.assert_allclose(ours[inner], theirs[inner], atol=2e-4)


@given(st.floats(1.0, 40.0), st.floats(5.0, 100.0))
@settings(max_examples=25, deadline=None)
def test_a_tone_is_scaled_by_the_gain_and_not_shifted(frequency, cutoff):
    x = tone(frequency, 5000)
    lowpass = Lowpass(len(x), RATE, cutoff)
    wanted = x * lowpass.gain(np.array([frequency]))
    inner = slice(1500, -1500)
    np.testing.assert_allclose(lowpass(x)[inner], wanted[inner], atol=2e-5)


@pytest.mark.parametrize("factor", [2, 7, 12])
def test_decimation_takes_every_nth_value(factor):
    x = noise(3001)
    full, coarse = Lowpass(3001, RATE, 10.0)(x), Lowpass(3001, RATE, 10.0, factor)(x)
    picked = full[::factor]
    assert coarse.shape == picked.shape
    inner = slice(80, -80)
    np.testing.assert_allclose(coarse[inner], picked[inner], atol=2e-3)


def test_derivatives_of_a_known_motion():
    t = np.arange(4000) / RATE
    w = 2 * np.pi * 1.3
    q = np.sin(w * t)
    lowpass = Lowpass(len(t), RATE, 60.0)
    x, dx, ddx = lowpass.derivatives(q)
    inner = slice(200, -200)
    np.testing.assert_allclose(x[inner], q[inner], atol=1e-9)
    np.testing.assert_allclose(dx[inner], (w * np.cos(w * t))[inner], atol=1e-8)
    np.testing.assert_allclose(ddx[inner], (-w * w * np.sin(w * t))[inner], atol=1e-6)
    v, dv = lowpass.rates(w * np.cos(w * t))
    np.testing.assert_allclose(v[inner], dx[inner], atol=1e-7)
    np.testing.assert_allclose(dv[inner], ddx[inner], atol=1e-5)


@given(st.integers(0, 1000), st.floats(-3, 3), st.integers(1, 9), st.integers(0, 40))
@settings(max_examples=25, deadline=None)
def test_filtering_is_linear_whatever_the_ends(seed, weight, factor, blind):
    """What makes both sides of an equation stay equal, ends included."""
    a, b = noise(700, 2, seed), noise(700, 2, seed + 1)
    lowpass = Lowpass(700, RATE, 12.0, factor, blind=blind)
    np.testing.assert_allclose(lowpass(a + weight * b), lowpass(a) + weight * lowpass(b), atol=1e-9)


def test_blind_ends_do_not_reach_into_the_run():
    x = noise(3000, 1)
    spoilt = x.copy()
    spoilt[:30] += 1e6
    spoilt[-30:] -= 1e6
    lowpass = Lowpass(3000, RATE, 10.0, 4, blind=30)
    np.testing.assert_allclose(lowpass(spoilt), lowpass(x), atol=1e-9)


def test_shapes_and_trailing_axes():
    x = np.random.default_rng(1).normal(size=(400, 3, 2))
    lowpass = Lowpass(400, RATE, 30.0, 3)
    out = lowpass(x)
    assert out.shape == (lowpass.kept, 3, 2)
    np.testing.assert_allclose(out[:, 1, 1], lowpass(x[:, 1, 1]), atol=1e-12)


@pytest.mark.parametrize("cutoff", [0.0, -1.0, 250.0, 400.0])
def test_impossible_cutoffs_are_refused_in_words(cutoff):
    with pytest.raises(UserError, match=r"cut-off .* expected between .* and half"):
        Lowpass(1000, RATE, cutoff)


@given(st.floats(-0.02, 0.02))
@settings(max_examples=25, deadline=None)
def test_a_delay_is_a_delay(seconds):
    t = np.arange(3000) / RATE
    moved = delayed(np.sin(2 * np.pi * 2.0 * t)[:, None], seconds, RATE)[:, 0]
    inner = slice(500, -500)
    np.testing.assert_allclose(
        moved[inner], np.sin(2 * np.pi * 2.0 * (t - seconds))[inner], atol=2e-3
    )


def test_delays_undo_each_other():
    x = Lowpass(3000, RATE, 30.0)(noise(3000, 2))
    back = delayed(delayed(x, 0.0043, RATE), -0.0043, RATE)
    np.testing.assert_allclose(back[400:-400], x[400:-400], atol=1e-3)
