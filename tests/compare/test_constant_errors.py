"""A constant error beside a slow one, whose memory is long for a short run."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import scipy

from pa10d.compare.curves import find_constant

RATE, SECONDS, MEMORY = 50.0, 15.0, 0.6  # Hz, s, s


def _slow(seed, constant):
    """A first-order drift of 0.7 N·m and a constant, as samples of a joint."""
    pole = np.exp(-1.0 / (RATE * MEMORY))
    noise = np.random.default_rng(seed).standard_normal(int(RATE * (SECONDS + 20 * MEMORY)))
    drift = scipy.signal.lfilter([np.sqrt(1 - pole**2)], [1, -pole], noise)[-int(RATE * SECONDS) :]
    error = constant + 0.7 * drift
    return SimpleNamespace(error=error, parts=[(error, np.ones(len(error), dtype=bool))], rate=RATE)


@pytest.mark.parametrize("seed", range(5))
def test_a_constant_is_told_beside_what_is_slow(seed):
    """5.8 of 5.9 N·m: "no region stands out: the error is spread over all of its motion"."""
    curve, p = find_constant(_slow(seed, 5.8), np.array([0.0, 1.0]))
    assert p < 0.01
    assert curve.share > 0.9
    assert curve.level == pytest.approx(5.8, rel=0.1)


def test_what_is_slow_alone_is_hardly_ever_one():
    told = [find_constant(_slow(seed, 0.0), np.array([0.0, 1.0]))[1] < 0.01 for seed in range(200)]
    assert np.mean(told) < 0.05
