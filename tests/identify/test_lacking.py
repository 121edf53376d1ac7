"""Standard errors know what the model lacks: motion predicts it, so more data do not average it."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import estimates, fourier, pa10_truth, recording

from pa10d.identify import identify
from pa10d.measurement.signals import Lowpass
from pa10d.regression.lacking import LOOKS, Stretch, lacking, weight_of

COLOURED = 8  # of ten draws of slow noise over a minute that are told from a function of motion
RATE, SECONDS, JOINTS = 200.0, 40.0, 2
UNMODELLED = {
    "cable": lambda q, dq: np.column_stack([3.0 * np.sin(2 * q[:, 1]), 0 * q[:, 1]]),
    "worn spot": lambda q, dq: np.column_stack(
        [4.0 * np.tanh(dq[:, 0] / 0.01) * np.exp(-(q[:, 0] ** 2) / 0.1), 0 * q[:, 1]]
    ),
}


def off(extra, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """(p,) error of every parameter in standard errors, with and without what the model lacks."""
    truth = pa10_truth(JOINTS)
    motion = fourier(JOINTS, SECONDS, RATE, seed)
    noise = np.random.default_rng(seed).normal(size=motion[1].shape)
    bare = recording(truth, motion, noise)
    full = recording(truth, motion, noise + extra(motion[1], motion[2]))
    models = [identify([run], truth.robot, name="m", cutoff=10.0) for run in (bare, full)]
    return tuple((estimates(m) - truth.values(m)) / np.sqrt(np.diag(m.covariance)) for m in models)


@pytest.mark.long
@pytest.mark.by_default("cable")
@pytest.mark.parametrize("name", UNMODELLED)
def test_intervals_hold_beside_an_effect_that_nobody_modelled(name):
    found = [off(UNMODELLED[name], seed) for seed in (1, 2, 3)]
    bare, full = (np.abs(np.concatenate([f[i] for f in found])) for i in (0, 1))
    assert np.mean(bare < 1.96) > 0.8  # of 36
    assert np.mean(full < 1.96) > 0.75  # less than half without


def stretch(residual: np.ndarray, q: np.ndarray, dq: np.ndarray) -> Stretch:
    keep, ddq = np.ones((len(q), 1), dtype=bool), np.gradient(dq)
    return Stretch(residual[:, None], keep, q[:, None], dq[:, None], ddq[:, None])


def test_noise_lacks_nothing_and_a_function_of_motion_does():
    lowpass = Lowpass(12_000, 200.0, 10.0, 5)
    t = np.arange(lowpass.kept) / 40.0
    q, dq = np.sin(1.3 * t) + 0.4 * np.sin(4.1 * t), np.cos(1.3 * t)
    own = 0.5 * q**2
    coloured = 0
    for seed in range(10):
        rng = np.random.default_rng(seed)
        white = lowpass(rng.standard_normal(12_000))
        slow = lowpass(np.convolve(rng.standard_normal(12_000), np.ones(200) / 14.0, "same"))
        assert lacking([stretch(white, q, dq)], lowpass)[0] < 0.1 * np.var(white)
        coloured += lacking([stretch(slow, q, dq)], lowpass)[0] == 0.0
        found = lacking([stretch(white + own, q, dq)], lowpass)
        assert found == pytest.approx(np.mean(own**2), rel=0.3)
    assert coloured >= COLOURED


def test_slow_noise_on_an_arm_of_many_joints_lacks_nothing_either():
    """Each joint more gives one more kind of states in which chance may find what comes again: of
    five joints' noise one in two stood for what the model lacks, and Stribeck friction with
    p = 1e-83 was dropped for having no number."""
    lowpass = Lowpass(12_000, 200.0, 10.0, 5)
    t, joints = np.arange(lowpass.kept) / 40.0, 5
    told = own = 0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        w, phase = rng.uniform(0.6, 4.0, (3, joints)), rng.uniform(0.0, 6.3, (3, joints))
        angle = t[:, None, None] * w + phase
        q, dq = np.sin(angle).sum(axis=1), (w * np.cos(angle)).sum(axis=1)
        ddq = -(w**2 * np.sin(angle)).sum(axis=1)
        noise = [
            lowpass(np.convolve(rng.standard_normal(12_000), np.ones(80) / 9.0, "same"))
            for _ in range(joints)
        ]
        slow, keep = np.column_stack(noise), np.ones((len(t), joints), dtype=bool)
        bent = q**2 - np.mean(q**2, axis=0)
        as_much = bent * slow.std(axis=0) / bent.std(axis=0)
        told += np.sum(lacking([Stretch(slow, keep, q, dq, ddq)], lowpass) == 0.0)
        own += np.sum(lacking([Stretch(slow + as_much, keep, q, dq, ddq)], lowpass) > 0.0)
    assert told >= 25, "of 30"
    assert own >= 27, "a function of motion as large as the noise is still found"


def test_more_of_the_same_is_no_new_evidence_on_what_is_lacking():
    few, many = (weight_of(np.array([2.0]), np.array([n]))[0] / n for n in (100.0, 10_000.0))
    assert few == pytest.approx(many) == pytest.approx(2.0 / LOOKS)
