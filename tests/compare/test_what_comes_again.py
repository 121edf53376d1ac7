"""Passes of one motion, numbers in: how often noise passes for what comes again."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom

from pa10d.judgement.repeatable import of_joint
from pa10d.judgement.repeats import Pass

RATE, PERIOD = 24.0, 192


def noise(rng, samples: int, memory: float) -> np.ndarray:
    """White, or slow with so many seconds of memory, or half of either (negative)."""
    white = rng.standard_normal(samples)
    if memory == 0.0:
        return white
    pole = np.exp(-1.0 / (abs(memory) * RATE))
    drive = rng.standard_normal(samples)
    drive[1:] *= np.sqrt(1.0 - pole**2)
    slow = lfilter([1.0], [1.0, -pole], drive)
    return slow + white * (memory < 0)


def passes(rng, memory: float, periods: int, within: bool) -> Pass:
    """Two runs of so many periods, or one run a period later; joints turn round in between."""
    free = np.ones(PERIOD, dtype=bool)
    for turn in rng.integers(0, PERIOD, rng.integers(4, 16)):
        free[max(0, turn - 2) : turn + 3] = False
    free = np.tile(free, periods)
    one, other = (noise(rng, periods * PERIOD, memory) for _ in range(2))
    if not within:
        return Pass(one[:, None], other[:, None], free[:, None], RATE, RATE / 2, None)
    late, early = one[PERIOD:, None], one[:-PERIOD, None]
    return Pass(late, early, free[PERIOD:, None], RATE, RATE / 2, PERIOD)


def chances(memory: float, periods: int, pairs: int) -> np.ndarray:
    """p of that many pairs of noise alone, half of them within a run, which it may outlive."""
    said = [
        of_joint([passes(np.random.default_rng([k, periods]), memory, periods, k % 2 == 0)], 0)
        for k in range(pairs)
    ]
    assert None not in said
    return np.array([one.p_value for one in said if one is not None])


@pytest.mark.parametrize(("memory", "periods"), [(0.0, 2), (2.0, 3), (-5.0, 2)])
def test_noise_of_any_colour_seldom_comes_again(memory, periods):
    p = chances(memory, periods, 60)
    assert np.sum(p < 0.01) <= binom.ppf(0.99, len(p), 0.03), "slow noise: decision 0150"
    assert np.sum(p < 1e-3) <= 1


@pytest.mark.long
@pytest.mark.parametrize("periods", [2, 5])
@pytest.mark.parametrize("memory", [0.0, 0.4, 2.0, 20.0, -0.4, -5.0])
def test_how_often_noise_comes_again(memory, periods):
    """Within a run of two periods slow noise alone may pass a little more often than it should."""
    p = chances(memory, periods, 1000)
    assert np.mean(p < 0.01) < 0.03
    assert np.mean(p < 1e-3) < 0.01


@pytest.mark.parametrize("within", [True, False])
def test_an_error_of_a_third_of_the_noise_comes_again(within):
    """1.2 times the floor: 0.66 times the noise, in one harmonic of the motion or in many."""
    seen = 0
    for k in range(8):
        rng = np.random.default_rng([k, 9])
        pair = passes(rng, 0.0, 5, within)
        cycles = rng.integers(1, 12)
        error = 0.66 * np.sqrt(2) * np.sin(2 * np.pi * cycles * np.arange(PERIOD) / PERIOD)
        shape = np.tile(error, 5)[: len(pair.one), None]
        found = of_joint([Pass(pair.one + shape, pair.other + shape, *tail(pair))], 0)
        seen += found is not None and found.p_value < 1e-4
    assert seen >= 7


def tail(pair: Pass):
    return pair.counts, pair.rate, pair.cutoff, pair.lag
