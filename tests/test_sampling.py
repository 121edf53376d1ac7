"""Stamps judged, and values brought to equal steps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from pa10d.measurement.sampling import Resampler, analyse, merge_duplicates, merged


def _resampled(t, values, smooth=True):
    timing = analyse(t)
    return timing, Resampler(t, timing)([values], smooth)[0]


def test_equal_steps_are_kept_as_they_are():
    t = 5.0 + 0.002 * np.arange(1000)
    timing = analyse(t)
    assert not timing.resampled
    assert timing.length == 1000
    np.testing.assert_allclose(timing.grid, t, atol=1e-9)


@pytest.mark.parametrize("rate", [100, 125, 250, 333.3, 500, 1000, 48.7])
@pytest.mark.parametrize("start", [0.0, -3.25, 1.7e9])
def test_rates_and_clocks(rate, start):
    timing = analyse(start + np.arange(2000) / rate)
    assert not timing.resampled
    assert timing.rate == pytest.approx(rate, rel=1e-6)
    assert timing.grid[0] == pytest.approx(start, abs=1e-6)


@pytest.mark.parametrize(("rate", "digits"), [(340, 3), (60, 2), (33.1, 2), (700, 3)])
def test_rounded_stamps_of_equal_steps_are_recognised(rate, digits):
    true = np.arange(3000) / rate
    timing = analyse(np.round(true, digits))
    assert not timing.resampled
    assert timing.rounding == pytest.approx(10.0**-digits)
    assert timing.rate == pytest.approx(rate, rel=1e-4)
    assert np.abs(timing.grid - true).max() < 0.02 / rate


def test_jitter_is_no_rounding():
    rng = np.random.default_rng(0)
    t = 0.005 * np.arange(1000) + np.round(rng.uniform(-1e-3, 1e-3, 1000), 3)
    timing = analyse(t)
    assert timing.resampled
    assert timing.rate == 200.0


def test_a_missing_sample_is_no_equal_step():
    t = np.delete(0.002 * np.arange(1000), 500)
    timing = analyse(t)
    assert timing.resampled
    assert timing.gaps == ()
    assert timing.length == 1000


def test_a_gap_is_found_and_marked():
    t = np.concatenate([0.002 * np.arange(500), 2.0 + 0.002 * np.arange(500)])
    timing = analyse(t)
    (gap,) = timing.gaps
    assert gap == pytest.approx((0.998, 1.002))
    marks = Resampler(t, timing).in_gap()
    inside = (timing.grid > 0.998 + 1e-9) & (timing.grid < 2.0 - 1e-9)
    np.testing.assert_array_equal(marks[inside], 1.0)
    assert marks.sum() <= inside.sum() + 1


def test_equal_steps_about_a_gap_are_not_irregular():
    """ "Steps off by up to 2.2e-12 ms" was told to let the robot's controller stamp its samples."""
    t = np.arange(2000) / 500.0
    timing = analyse(np.delete(t, np.s_[700:1300]))
    assert timing.gaps
    assert not timing.uneven


def test_duplicates_become_their_mean():
    t = np.array([0.0, 1, 1, 2, 3, 3, 3])
    starts = merge_duplicates(t)
    np.testing.assert_array_equal(t[starts], [0, 1, 2, 3])
    np.testing.assert_allclose(merged(np.array([1.0, 2, 4, 8, 1, 2, 6]), starts), [1, 3, 8, 3])
    block = np.stack([np.arange(7.0), 2 * np.arange(7.0)], axis=1)
    np.testing.assert_allclose(merged(block, starts)[:, 1], [0, 3, 6, 10])
    assert merge_duplicates(np.arange(5.0)) is None


def test_cubics_are_exact_and_splines_agree():
    """A cubic polynomial is met exactly; a sine as well as scipy's spline meets it."""
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.0015, 0.0025, 4000))
    poly = np.polynomial.Polynomial([1.0, -2.0, 0.5, 0.25])
    timing, values = _resampled(t, poly(t))
    inner = slice(3, -3)
    np.testing.assert_allclose(values[inner], poly(timing.grid)[inner], atol=1e-11)
    wave = np.sin(2 * np.pi * 20 * t)
    _, ours = _resampled(t, wave)
    true = np.sin(2 * np.pi * 20 * timing.grid)
    spline = CubicSpline(t, wave)(timing.grid)
    assert np.abs(ours - true)[inner].max() < 3e-4
    assert np.abs(spline - true)[inner].max() < 3e-4
    line = np.interp(timing.grid, t, wave)
    assert np.abs(line - true).max() > 20 * np.abs(ours - true)[inner].max()


def test_noise_is_not_amplified_even_by_very_uneven_stamps():
    rng = np.random.default_rng(5)
    t = np.cumsum(rng.choice([1e-5, 2e-3, 4e-3], 5000))
    noise = rng.normal(size=5000)
    _, values = _resampled(t, noise)
    assert np.abs(values).max() < 1.3 * np.abs(noise).max()
    assert values.std() < noise.std()


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(1e-4, 1e-1), min_size=4, max_size=60), st.floats(-1e3, 1e3))
def test_any_stamps_give_a_grid_within_them_and_a_line_stays_a_line(steps, start):
    t = start + np.concatenate([[0.0], np.cumsum(steps)])
    timing = analyse(t)
    if timing.resampled:
        assert timing.grid[0] == t[0]
        assert timing.grid[-1] <= t[-1] + 1e-9
        assert timing.grid[-1] > t[-1] - timing.period - 1e-9
        values = Resampler(t, timing)([3 * t + 1])[0]
        np.testing.assert_allclose(values, 3 * timing.grid + 1, rtol=1e-9, atol=1e-6)
    else:
        assert timing.length == len(t)
        assert np.abs(timing.grid - t).max() <= 0.5 * timing.period
