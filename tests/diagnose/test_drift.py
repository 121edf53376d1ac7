"""A sensor that drifts as long as it records is noise: it proves no constant and no curve."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.ndimage
from bare_sides import RATE, ar1, bare_side

from pa10d.diagnose.evidence.drift import GoesWithMotion, drift, lines
from pa10d.diagnose.evidence.held_out import judge, padded, quadratic_form

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


def test_white_noise_hardly_drifts():
    rng = np.random.default_rng(4)
    drifts = []
    for _ in range(100):
        noise = rng.standard_normal(SAMPLES) / np.sqrt(SAMPLES)
        drifts.append(drift(np.fft.rfft(noise, 2 * SAMPLES), 2 * SAMPLES, SAMPLES)[0])
    typical = np.median(drifts, axis=0)
    assert typical[2] < 1.5  # at the first ordinate
    assert np.all(typical[40:] < 1.05)
    assert np.all(np.diff(typical[:40]) <= 0.0)


def test_a_spectrum_of_too_few_ordinates_stays_as_it_is():
    assert np.all(np.array(drift(np.ones(9, dtype=complex), 16, 8)) == 1.0)


def lacking(rng: np.random.Generator, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two minutes' motion, and what a model without its curves leaves of it."""
    angle = 2 * np.pi * np.array([0.04, 0.055, 0.09]) * t[:, None] + rng.uniform(0, 6, 3)
    q, dq = np.sin(angle).sum(axis=1), np.cos(angle).sum(axis=1)
    motion = np.column_stack([np.sin(q), np.cos(q), dq, np.sign(dq)])
    return motion, motion @ rng.normal(0.0, 0.5, 4)


def test_what_goes_with_the_motion_is_no_drift():
    """A constant beside an error that the model makes as the arm moves: four known, unnamed."""
    rng, constant = np.random.default_rng(6), np.ones(SAMPLES)
    length, t = padded(SAMPLES), np.arange(SAMPLES) / RATE
    blind, seeing, drifted = [], [], []
    for _ in range(60):
        motion, error = lacking(rng, t)
        noise = error - error.mean() + 0.1 * rng.standard_normal(SAMPLES)
        moved = GoesWithMotion.of(motion, EVERY, length)
        blind.append(quadratic_form(constant, noise, EVERY, RATE))
        seeing.append(quadratic_form(constant, noise, EVERY, RATE, moved))
        mean = drifting(rng)
        left = error - error.mean() + mean - mean.mean()
        drifted.append(mean.sum() / np.sqrt(quadratic_form(constant, left, EVERY, RATE, moved)))
    assert np.median(np.array(blind) / seeing) > 4.0
    assert np.sqrt(np.mean(np.square(drifted))) < 2.0  # a drift beside it is seen all the same


def test_of_a_motion_that_repeats_itself_every_harmonic_may_be_left():
    """Curves that nobody thought of, of a motion of two rounds, are none of a drift's."""
    rng, length = np.random.default_rng(7), padded(SAMPLES)
    turn = 2 * np.pi * 2 * np.arange(SAMPLES) / SAMPLES
    motion = np.column_stack([np.sin(turn), np.cos(turn)])
    curves = sum(np.cos(k * turn + k) / k for k in (1, 2, 3, 4))
    noise = curves + 0.1 * rng.standard_normal(SAMPLES)
    assert list(np.flatnonzero(lines(motion)) + 1) == list(range(2, 33, 2))
    spectrum = np.fft.rfft(noise, length)
    rises = [
        drift(spectrum, length, SAMPLES, moved)[0][0]
        for moved in (None, GoesWithMotion.of(motion, EVERY, length))
    ]
    assert rises[0] > 100.0 * rises[1]


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
