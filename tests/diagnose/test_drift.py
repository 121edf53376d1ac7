"""A sensor that drifts as long as it records is noise: it proves no constant and no curve."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.ndimage
from bare_sides import RATE, ar1, bare_side

from pa10d.diagnose.evidence.drift import rise
from pa10d.diagnose.evidence.held_out import judge, quadratic_form

SAMPLES = 2000
DRIFT = float(np.exp(-1.0 / (0.75 * SAMPLES)))  # remembers for three quarters of the run
EVERY = np.ones(SAMPLES, dtype=bool)


def drifting(rng: np.random.Generator) -> np.ndarray:
    return 0.1 * rng.standard_normal(SAMPLES) + 0.3 * ar1(rng, SAMPLES, DRIFT)


def errors_of_a_mean(make) -> np.ndarray:
    """By how many of its stated errors the mean of noise is off."""
    out = []
    for _ in range(200):
        noise, constant = make(), np.ones(SAMPLES)
        variance = quadratic_form(constant, noise - noise.mean(), EVERY, RATE)
        out.append(noise.sum() / np.sqrt(variance))
    return np.array(out)


def test_a_constant_is_not_proven_by_a_drift():
    rng = np.random.default_rng(1)
    off = errors_of_a_mean(lambda: drifting(rng))
    assert np.sqrt(np.mean(off**2)) < 2.0
    assert np.mean(np.abs(off) > 3) < 0.06


def test_a_constant_beside_white_noise_is_known_as_well_as_before():
    rng = np.random.default_rng(2)
    off = errors_of_a_mean(lambda: rng.standard_normal(SAMPLES))
    assert 0.5 < np.sqrt(np.mean(off**2)) < 1.2


@pytest.mark.parametrize("make", [lambda rng: rng.standard_normal(SAMPLES), drifting])
def test_what_moves_is_judged_as_sharply_beside_a_drift(make):
    rng = np.random.default_rng(3)
    wave = np.sin(2 * np.pi * 0.1 * np.arange(SAMPLES) / RATE)
    off = []
    for _ in range(200):
        noise = make(rng)
        off.append(wave @ noise / np.sqrt(quadratic_form(wave, noise, EVERY, RATE)))
    assert 0.8 < np.sqrt(np.mean(np.square(off))) < 1.2


def test_white_noise_hardly_rises():
    rng = np.random.default_rng(4)
    rises = []
    for _ in range(100):
        power = np.abs(np.fft.rfft(rng.standard_normal(SAMPLES), 2 * SAMPLES)) ** 2
        rises.append(rise(power, SAMPLES))
    typical = np.median(rises, axis=0)
    assert typical[2] < 1.5  # at the first ordinate
    assert np.all(typical[40:] < 1.05)
    assert np.all(np.diff(typical[:40]) <= 0.0)


def test_a_spectrum_of_too_few_ordinates_stays_as_it_is():
    assert np.all(rise(np.ones(9), 8) == 1.0)


def test_a_drift_foretells_its_neighbours_and_is_noise_all_the_same():
    """Made of the residual itself, a change takes the drift along."""
    rng = np.random.default_rng(5)
    side = bare_side([np.zeros((SAMPLES, 1))])
    apart, itself = [], []
    for _ in range(40):
        residual = drifting(rng)
        change = {0: scipy.ndimage.gaussian_filter1d(residual, RATE)}
        apart.append(judge(side, {0: residual}, change).p_value)
        itself.append(judge(side, {0: residual}, change, of_itself=True).p_value)
    assert np.mean(np.array(apart) < 1e-4) > 0.5
    assert np.mean(np.array(itself) < 1e-4) < 0.03
