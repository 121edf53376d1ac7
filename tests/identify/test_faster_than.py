"""Fitting only the samples in which friction is linear."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import fourier, pa10_truth, recording

from pa10d.common.errors import UserError
from pa10d.identify import identify
from pa10d.measurement.recording import Recording

LIMIT = (0.3, 0.3)
RISE, WIDTH = 4.0, 0.08  # of the friction that is not linear: N·m, rad/s


def slow_friction(seed: int) -> tuple[Recording, Recording]:
    """What is measured, and what it would be without the friction at low speed."""
    truth = pa10_truth(2)
    motion = fourier(2, 24.0, 500.0, seed=seed)
    dq = motion[2]
    noise = 0.1 * np.random.default_rng(seed).normal(size=dq.shape)
    plain = recording(truth, motion, noise, f"run {seed}")
    extra = RISE * np.exp(-((dq / WIDTH) ** 2)) * np.tanh(dq / 0.01)
    return Recording(plain.name, plain.t, plain.q, plain.tau + extra), plain


def values(model, effect_id):
    return np.array([t.coefficients[0] for t in model.terms if t.effect_id == effect_id])


def test_fast_samples_give_the_friction_that_holds_above_the_limit():
    hidden, plain = slow_friction(3)
    truth = identify([plain], pa10_truth(2).robot, name="truth", cutoff=10.0)
    whole = identify([hidden], pa10_truth(2).robot, name="B", cutoff=10.0)
    fast = identify([hidden], pa10_truth(2).robot, name="A", cutoff=10.0, faster_than=LIMIT)
    right = values(truth, "coulomb")
    off_whole, off_fast = (np.abs(values(m, "coulomb") - right) for m in (whole, fast))
    assert np.all(off_whole > 0.3)
    assert np.all(off_fast < 0.1)
    assert fast.notes.faster_than == tuple(LIMIT)
    sharp = [t.shape["v0"] for t in fast.terms if t.effect_id == "coulomb"]
    assert max(sharp) < 1e-3  # nothing slow was fitted that could tell it
    assert np.all(fast.noise < 0.5 * whole.noise)


def test_a_limit_of_nothing_changes_next_to_nothing():
    _, plain = slow_friction(3)
    robot = pa10_truth(2).robot
    usual = identify([plain], robot, name="m", cutoff=10.0)
    zero = identify([plain], robot, name="m", cutoff=10.0, faster_than=(0.0, 0.0))
    assert zero.h == pytest.approx(usual.h, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        ((0.3,), r"faster_than: found \[0.3\], expected 2 speeds"),
        ((0.3, -1.0), "faster_than: .*expected 2 speeds"),
        ((0.3, 50.0), r"joint 2 is faster than 50 rad/s for 0 s only, expected at least 1 s"),
    ],
)
def test_impossible_limits_are_refused(limit, words):
    _, plain = slow_friction(3)
    with pytest.raises(UserError, match=words):
        identify([plain], pa10_truth(2).robot, name="m", cutoff=10.0, faster_than=limit)
