"""The statistics of a held-out judgement on noise whose properties are known exactly."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from bare_sides import RATE, ar1, bare_side, smooth_signal
from how_often import how_often
from scipy import stats

from pa10d.diagnose.evidence.held_out import (
    ModelUncertainty,
    fit_side_power,
    judge,
    quadratic_form,
    rivalry,
    spread,
)

SAMPLES = 1500
NOISES = {"white": 0.0, "ar1": 0.9, "slow": 0.98}
SLOWEST_BY_DEFAULT = [
    pytest.param(phi, id=name, marks=() if name == "slow" else pytest.mark.long)
    for name, phi in NOISES.items()
]


def gaps(rng: np.random.Generator, samples: int) -> np.ndarray:
    keep = np.ones(samples, dtype=bool)
    for start in rng.integers(0, samples - 60, 6):
        keep[start : start + 60] = False
    return keep


@pytest.mark.parametrize("holes", [False, True])
@pytest.mark.parametrize("phi", NOISES.values(), ids=NOISES)
def test_quadratic_form_is_the_exact_variance(phi, holes):
    rng = np.random.default_rng(11)
    signal = smooth_signal(rng, SAMPLES)
    keep = gaps(rng, SAMPLES) if holes else np.ones(SAMPLES, dtype=bool)
    signal = np.where(keep, signal, 0.0)
    exact = signal @ scipy.linalg.matmul_toeplitz(phi ** np.arange(SAMPLES), signal)
    found = [
        quadratic_form(signal, np.where(keep, ar1(rng, SAMPLES, phi), 0.0), keep, RATE)
        for _ in range(60)
    ]
    assert np.mean(found) == pytest.approx(exact, rel=0.2)


def test_quadratic_form_of_nothing_kept_is_nothing():
    empty = np.zeros(100, dtype=bool)
    assert quadratic_form(np.zeros(100), np.zeros(100), empty, RATE) == 0.0


@pytest.mark.parametrize("phi", NOISES.values(), ids=NOISES)
def test_judge_finds_slope_one_for_a_true_column(phi):
    rng = np.random.default_rng(12)
    slopes, z = [], []
    for _ in range(40):
        change = {0: np.concatenate([smooth_signal(rng, SAMPLES) for _ in range(2)])}
        noise = np.concatenate([ar1(rng, SAMPLES, phi) for _ in range(2)])
        side = bare_side([np.zeros((SAMPLES, 1))] * 2)
        found = judge(side, {0: 2.0 * noise + change[0]}, change)
        slopes.append(found.slope)
        z.append(found.z / found.slope)  # one over the standard error that it claims
    assert np.mean(slopes) == pytest.approx(1.0, abs=4 * np.std(slopes) / np.sqrt(40))
    assert np.std(slopes) * np.mean(z) == pytest.approx(1.0, abs=0.4)


@pytest.mark.long
@pytest.mark.parametrize("phi", SLOWEST_BY_DEFAULT)
def test_z_of_a_chance_change_is_standard_normal(phi, pytestconfig):
    """Two joints, two runs, gaps; the change has nothing to do with the noise and is small (a
    large one that is wrong counts itself as noise: it errs on the safe side)."""
    rng = np.random.default_rng(13)
    draws = how_often(pytestconfig, 75, 300)
    wider = np.sqrt(300 / draws)
    z, p = [], []
    for _ in range(draws):
        keep = [np.column_stack([gaps(rng, SAMPLES) for _ in range(2)]) for _ in range(2)]
        side = bare_side([np.zeros((SAMPLES, 2))] * 2, keep)
        noise = [
            np.column_stack([ar1(rng, SAMPLES, phi), 5 * ar1(rng, SAMPLES, 0)]) for _ in range(2)
        ]
        wave = [0.02 * np.column_stack([smooth_signal(rng, SAMPLES)] * 2) for _ in range(2)]
        found = judge(side, _rows(side, noise), _rows(side, wave))
        z.append(found.z)
        p.append(found.p_value)
    assert abs(np.mean(z)) < 4 / np.sqrt(draws)
    assert 1 - 0.15 * wider < np.std(z) < 1 + 0.12 * wider
    assert np.mean(np.array(p) < 0.01) < 0.01 + 0.02 * wider
    assert stats.kstest(p, "uniform").pvalue > 1e-3


@pytest.mark.long
def test_too_little_noise_to_estimate_does_not_make_significance():
    """Slow noise has few independent samples: 30 s hold what looks like hundreds."""
    rng = np.random.default_rng(14)
    z = []
    for _ in range(300):
        side = bare_side([np.zeros((SAMPLES, 1))])
        change = 0.02 * smooth_signal(rng, SAMPLES)
        z.append(judge(side, {0: ar1(rng, SAMPLES, 0.99)}, {0: change}).z)
    assert np.std(z) < 1.35


def _rows(side, runs):
    return {
        j: np.concatenate([r[k[:, j], j] for r, k in zip(runs, side.keep, strict=True)])
        for j in range(side.n)
    }


def test_before_after_and_gain_are_what_they_say():
    rng = np.random.default_rng(15)
    side = bare_side([np.zeros((SAMPLES, 2))])
    change = {0: smooth_signal(rng, SAMPLES), 1: np.zeros(SAMPLES)}
    r0 = {0: change[0] + 0.1 * rng.standard_normal(SAMPLES), 1: rng.standard_normal(SAMPLES)}
    found = judge(side, r0, change)
    after = [r0[j] - change[j] for j in (0, 1)]
    assert found.before == pytest.approx([np.std(r0[j]) for j in (0, 1)], rel=0.02)
    assert found.after == pytest.approx([np.sqrt(np.mean(r**2)) for r in after])
    drop = (np.sum(r0[0] ** 2) - np.sum(after[0] ** 2)) / np.mean(r0[0] ** 2)
    assert found.gain == pytest.approx(drop)
    assert found.p_value == pytest.approx(stats.norm.sf(found.z))
    assert found.worse == ()
    assert found.cluster_t > 3


def test_a_joint_that_gets_worse_is_named():
    rng = np.random.default_rng(16)
    side = bare_side([np.zeros((SAMPLES, 2))])
    wave = smooth_signal(rng, SAMPLES)
    r0 = {j: 0.2 * rng.standard_normal(SAMPLES) for j in (0, 1)}
    r0[0] = r0[0] + wave
    harmful = judge(side, r0, {0: wave, 1: 0.15 * wave})
    assert harmful.worse == (1,)
    assert judge(side, r0, {0: wave, 1: 0.001 * wave}).worse == ()


@pytest.mark.parametrize("phi", [pytest.param(0.0, marks=pytest.mark.long), 0.9])
def test_fit_side_power_of_fitted_noise_is_chi_squared(phi, pytestconfig):
    """k columns that have nothing to do with the noise are fitted to it: the gain is χ² with k
    degrees of freedom once the colour of the noise is accounted for."""
    rng = np.random.default_rng(17)
    draws = how_often(pytestconfig, 250, 1000)
    wider = np.sqrt(1000 / draws)
    p = []
    for _ in range(draws):
        side = bare_side([np.zeros((SAMPLES, 1))])
        noise = ar1(rng, SAMPLES, phi)
        columns = smooth_signal(rng, SAMPLES)[:, None]
        change = columns @ np.linalg.lstsq(columns, noise, rcond=None)[0]
        p.append(stats.chi2.sf(fit_side_power(side, {0: noise}, {0: change}), 1))
    # what the fit has taken from the noise makes p slightly too small
    assert np.mean(np.array(p) < 0.01) < 0.01 + 0.02 * wider
    assert np.mean(np.array(p) < 0.1) == pytest.approx(0.1, abs=0.04 * wider)


def test_rivals_that_predict_the_same_cannot_be_told_apart():
    rng = np.random.default_rng(18)
    side = bare_side([np.zeros((SAMPLES, 2))])
    one = {0: smooth_signal(rng, SAMPLES), 1: np.zeros(SAMPLES)}
    r0 = {0: one[0] + rng.standard_normal(SAMPLES), 1: rng.standard_normal(SAMPLES)}
    assert rivalry(side, r0, one, one) == pytest.approx((1.0, 0.0))
    other = {0: np.zeros(SAMPLES), 1: one[0]}
    overlap, z = rivalry(side, r0, one, other)
    assert overlap == pytest.approx(0.0)
    assert z > 10
    assert rivalry(side, r0, other, one)[1] < -4


@pytest.mark.long
def test_the_lead_of_equal_rivals_is_standard_normal():
    """The truth lies half-way between two changes: neither may lead significantly."""
    rng = np.random.default_rng(19)
    z = []
    for _ in range(300):
        side = bare_side([np.zeros((SAMPLES, 1))])
        a, b = smooth_signal(rng, SAMPLES), smooth_signal(rng, SAMPLES)
        b = 0.95 * a + 0.3 * b
        b *= np.linalg.norm(a) / np.linalg.norm(b)
        r0 = 0.05 * (a + b) / 2 + ar1(rng, SAMPLES, 0.8)
        z.append(rivalry(side, {0: r0}, {0: 0.05 * a}, {0: 0.05 * b})[1])
    assert abs(np.mean(z)) < 4 / np.sqrt(300)
    assert 0.85 < np.std(z) < 1.15


def test_spread_is_the_rms_per_joint():
    assert spread({1: np.array([3.0, -3.0]), 0: np.zeros(4)}) == pytest.approx([1e-12, 3.0])


@pytest.mark.long
def test_what_the_model_is_off_by_counts_as_doubt(pytestconfig):
    """A model of 20 columns is fitted to little data with slow noise. What it is off by moves
    with the motion, and a candidate that resembles the motion finds it on the held-out side."""
    rng = np.random.default_rng(20)
    phi, width, plain, honest = 0.97, 20, [], []
    gamma = phi ** np.arange(SAMPLES)
    draws = how_often(pytestconfig, 75, 150)
    wider = np.sqrt(150 / draws)
    for _ in range(draws):
        train, held = (
            np.column_stack([smooth_signal(rng, SAMPLES) for _ in range(width)]) for _ in range(2)
        )
        inverse = np.linalg.pinv(train)
        covariance = inverse @ scipy.linalg.matmul_toeplitz(gamma, inverse.T)
        r0 = {0: ar1(rng, SAMPLES, phi) - held @ (inverse @ ar1(rng, SAMPLES, phi))}
        change = {0: 0.1 * held @ rng.standard_normal(width) / np.sqrt(width)}
        side = bare_side([np.zeros((SAMPLES, 1))])
        plain.append(judge(side, r0, change).z)
        honest.append(judge(side, r0, change, ModelUncertainty({0: held}, covariance)).z)
    assert np.std(plain) > 1.2
    assert 1 - 0.25 * wider < np.std(honest) < 1 + 0.12 * wider
