"""Averaging over periods and the Fourier fit."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.paper.periods import (
    average_periods,
    fourier_motion,
    mean_period,
    suggested_cutoff,
)
from pa10d.trajectory.motions import Fourier

RNG = np.random.default_rng(3)
SERIES = Fourier(40.0, 0.0, 0.1, *RNG.normal(size=(1, 3)), *0.2 * RNG.normal(size=(2, 5, 3)))


def test_the_mean_period_and_its_noise():
    t = np.arange(20_001) / 500.0
    clean = SERIES.path(t)[0]
    sigma = np.array([0.1, 0.5, 2.0])
    noisy = clean + sigma * np.random.default_rng(0).normal(size=clean.shape)
    found = average_periods(t, noisy, 0.1)
    assert found.periods == 4
    assert found.noise == pytest.approx(sigma, rel=0.02)
    left = found.mean - SERIES.path(found.t)[0]
    assert np.sqrt(np.mean(left**2, axis=0)) == pytest.approx(sigma / 2, rel=0.03)
    assert not found.drifts.any()
    assert found.warnings("torque", "N·m") == []


def test_a_period_that_is_no_whole_number_of_samples():
    slow = Fourier(40.0, 0.0, 1 / 9.873, SERIES.centre, SERIES.a, SERIES.b)
    t = np.arange(20_001) / 500.0
    found = average_periods(t, slow.path(t)[0], 1 / 9.873, start=0.123)
    assert found.periods == 4
    assert found.mean == pytest.approx(slow.path(0.123 + found.t)[0], abs=1e-6)
    assert found.noise.max() < 1e-6


def test_drift_is_told_from_noise():
    t = np.arange(20_001) / 500.0
    values = SERIES.path(t)[0] + 0.2 * np.random.default_rng(1).normal(size=(len(t), 3))
    values[:, 1] += 0.15 * t / 40.0
    found = average_periods(t, values, 0.1)
    assert list(found.drifts) == [False, True, False]
    assert "joint 2: torque drifts over the periods" in found.warnings("torque", "N·m")[0]


def test_one_period_cannot_be_averaged():
    t = np.arange(6_000) / 500.0
    with pytest.raises(UserError, match="1 whole periods of 10 s; expected at least 2"):
        average_periods(t, np.zeros((len(t), 1)), 0.1)


def test_the_fit_finds_the_series_and_its_derivatives():
    t = np.arange(10_000) / 500.0
    q, dq, ddq = SERIES.path(t)
    noisy = q + 1e-5 * np.random.default_rng(0).normal(size=q.shape)
    found = fourier_motion(t, noisy, 0.1, 5)
    assert found.coefficients == pytest.approx(
        np.vstack([SERIES.centre, SERIES.a, SERIES.b]), abs=1e-6
    )
    assert found.dq == pytest.approx(dq, abs=1e-5)
    assert found.ddq == pytest.approx(ddq, abs=1e-4)
    assert found.trusted.all()
    assert found.warnings() == []


def test_motion_outside_the_series_is_measured_and_warned_about():
    t = np.arange(10_000) / 500.0
    q, _, ddq = SERIES.path(t)
    omega = 2 * np.pi * 2.0
    size = 0.2 * np.sqrt(np.mean(ddq[:, 1] ** 2)) * np.sqrt(2) / omega**2
    q[:, 1] += size * np.sin(omega * t)  # a fifth of the acceleration at 2 Hz
    found = fourier_motion(t, q, 0.1, 5)
    assert found.outside[1] == pytest.approx(0.2, rel=0.05)
    assert list(found.trusted) == [True, False, True]
    warning = found.warnings()
    assert len(warning) == 1
    assert "joint 2: 20 % of the acceleration lies outside the series" in warning[0]


def test_a_joint_that_stands_is_no_warning():
    t = np.arange(5_000) / 500.0
    q = SERIES.path(t)[0]
    q[:, 2] = 0.3
    assert fourier_motion(t, q, 0.1, 5).warnings() == []


@pytest.mark.parametrize(
    ("fundamental", "harmonics", "cutoff"), [(0.1, 5, 5.0), (0.02, 3, 2.0), (1.0, 10, 40.0)]
)
def test_the_cutoff_follows_the_highest_harmonic_within_reason(fundamental, harmonics, cutoff):
    assert suggested_cutoff(fundamental, harmonics) == pytest.approx(cutoff)


def test_whole_periods_count_though_the_next_one_has_not_begun():
    t = np.arange(20_000) / 500.0
    assert average_periods(t, SERIES.path(t)[0], 0.1).periods == 4


def test_the_mean_period_goes_on_at_both_ends_as_the_motion_does():
    t = np.arange(20_000) / 500.0
    q, dq, _ = SERIES.path(t)
    found = mean_period(average_periods(t, q, 0.1), average_periods(t, dq, 0.1), 1.5, "mean")
    assert found.duration == pytest.approx(13.0, abs=0.01)
    assert found.q == pytest.approx(SERIES.path(found.t - 1.5)[0], abs=1e-9)
    assert found.tau == pytest.approx(SERIES.path(found.t - 1.5)[1], abs=1e-9)
