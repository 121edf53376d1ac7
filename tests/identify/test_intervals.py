"""Stated errors against what repetition shows, on white and on coloured noise."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.signal
from synthetic import estimates, fourier, pa10_truth, recording

from pa10d.dynamics import regressor
from pa10d.effects.base import smooth_sign
from pa10d.identify import identify

RATE, SECONDS, JOINTS = 200.0, 16.0, 2
SIGMA = np.array([1.0, 0.6])


def white(rng):
    return rng.normal(size=(round(RATE * SECONDS), JOINTS)) * SIGMA


def coloured(rng):
    """First-order noise with a corner at 1 Hz: well inside the band of the motion."""
    return scipy.signal.lfilter([0.25], [1.0, -0.97], white(rng), axis=0)


def repeated(noise, seeds):
    """(estimates, standard errors, truth), one row per seed."""
    truth = pa10_truth(JOINTS)
    motion = fourier(JOINTS, SECONDS, RATE)
    found, errors = [], []
    for seed in range(seeds):
        run = recording(truth, motion, noise(np.random.default_rng(seed)))
        model = identify([run], truth.robot, name="m", cutoff=10.0)
        found.append(estimates(model))
        errors.append(model.std_errors)
    return np.array(found), np.array(errors), truth.values(model), model


def covered(found, errors, truth):
    return np.abs(found - truth) <= 1.96 * errors


@pytest.mark.long
@pytest.mark.parametrize("noise", [pytest.param(white, marks=pytest.mark.long), coloured])
def test_intervals_cover_over_all_parameters(noise):
    found, errors, truth, _ = repeated(noise, 30)
    assert 0.90 <= covered(found, errors, truth).mean() <= 0.99


@pytest.mark.long
@pytest.mark.parametrize("noise", [white, coloured])
def test_intervals_cover_in_two_hundred_seeds(noise):
    found, errors, truth, _ = repeated(noise, 240)
    inside = covered(found, errors, truth)
    assert 0.90 <= inside.mean() <= 0.99
    # one parameter alone: 95 % within what 240 repetitions can tell, 3 standard errors
    assert inside.mean(axis=0).min() > 0.95 - 0.05 - 3 * np.sqrt(0.05 * 0.95 / 240)


def cramer_rao(model):
    """(p,) standard errors of the best unbiased estimate from unfiltered data, v0 unknown too."""
    truth = pa10_truth(JOINTS)
    _, q, dq, ddq = fourier(JOINTS, SECONDS, RATE)
    columns = [*np.moveaxis(regressor(truth.robot, q, dq, ddq, model.base.kept), 2, 0)]

    def own(j, values):
        column = np.zeros_like(q)
        column[:, j] = values
        return column

    for term in model.terms:
        j = term.joints[0]
        kinds = {"rotor_inertia": ddq[:, j], "viscous": dq[:, j]}
        columns.append(own(j, kinds.get(term.effect_id, smooth_sign(dq[:, j], truth.v0))))
    for j in range(JOINTS):
        high, low = (smooth_sign(dq[:, j], truth.v0 * f) for f in (1.01, 0.99))
        columns.append(own(j, truth.coulomb[j] * (high - low)))
    matrix = (np.stack(columns, 2) / SIGMA[:, None]).reshape(-1, len(columns))
    return np.sqrt(np.diag(np.linalg.inv(matrix.T @ matrix)))[: len(estimates(model))]


@pytest.mark.parametrize(
    "seeds", [pytest.param(20, id="few"), pytest.param(240, id="many", marks=pytest.mark.long)]
)
def test_white_noise_reaches_the_cramer_rao_bound(seeds):
    found, errors, _, model = repeated(white, seeds)
    bound = cramer_rao(model)
    scatter = np.sqrt(np.mean(found.var(axis=0, ddof=1) / bound**2))
    assert scatter < 1.2
    assert 0.85 < np.mean(errors / bound) < 1.2
    if seeds > 200:
        assert np.all(found.std(axis=0, ddof=1) / bound < 1.2 * (1 + 2 / np.sqrt(2 * seeds)))


def test_errors_grow_with_noise_that_depends_on_the_pose():
    """Stationary errors are an assumption; errors that are not are seen by blocks of time."""
    truth = pa10_truth(JOINTS)
    motion = fourier(JOINTS, 40.0, RATE)
    rng = np.random.default_rng(5)
    even = rng.normal(size=motion[1].shape)
    lumpy = even * np.where(np.arange(len(even)) % 800 < 100, 3.0, 0.3)[:, None]
    slow = scipy.signal.lfilter([0.05], [1, -0.95], lumpy, axis=0) * 4
    model = identify([recording(truth, motion, slow)], truth.robot, name="m", cutoff=10.0)
    error = np.abs(estimates(model) - truth.values(model))
    assert np.mean(error < 2.5 * model.std_errors) > 0.8
