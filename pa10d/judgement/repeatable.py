"""Does an error come again where the motion does? Noise does not, whatever its colour.

Two passes of one motion have the model's error in common; their difference has noise alone, and
tells how much two noises of this colour go together by accident (Bartlett 1935). Within one run
slow noise may remember the earlier pass, but it remembers the moments before and after as well: an
error that belongs to the motion is alike at the same place only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
import scipy.fft
from numpy.typing import NDArray

from pa10d.judgement.repeats import Pass, passes
from pa10d.judgement.residuals import RunResidual

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

FEWEST = 30  # pairs of samples of the band below which nothing is said
WORTH = 4.0  # independent ones
STANDS_OUT = 2.0  # standard deviations above what it is like elsewhere
ALIKE_APART = 1.0  # the same between two runs, where no noise can remember
ELSEWHERE = (0.125, 0.5)  # of a period: how far off the same place the moments around are taken


@dataclass(frozen=True)
class Repeatable:
    """Of one joint. p_value: that errors which know nothing of each other are as alike by accident;
    share: of the squared error, that both passes have in common; pairs: of samples."""

    p_value: float
    share: float
    pairs: int


def repeatable(runs: Sequence[RunResidual]) -> list[Repeatable | None]:
    """Per joint; None where no motion comes again for long enough."""
    found = list(passes(list(runs)))
    return [_of_joint(found, j) for j in range(runs[0].error.shape[1])]


def _of_joint(found: Sequence[Pass], joint: int) -> Repeatable | None:
    tests, shared, power, pairs = [], 0.0, 0.0, 0
    for pair in found:
        one, other, counts = pair.in_band(joint)
        if counts.sum() < FEWEST:
            continue
        shared += float(one[counts] @ other[counts])
        power += 0.5 * float(one[counts] @ one[counts] + other[counts] @ other[counts])
        pairs += int(counts.sum())
        tests.append(_alike(one, other, counts, pair.samples_apart))
    if not tests:
        return None
    return Repeatable(min(1.0, len(tests) * min(tests)), shared / max(power, 1e-300), pairs)


def _alike(one: Array, other: Array, counts: Mask, apart: int | None) -> float:
    """p, one-sided. one, other (M,); apart: samples from the one to the other within a run."""
    x, y = (np.where(counts, v - v[counts].mean(), 0.0) for v in (one, other))
    number = float(counts.sum())
    noise = _correlation((x - y) / np.sqrt(2.0), (x - y) / np.sqrt(2.0))[: max(2, len(x) // 4)]
    rho = noise / max(float(noise[0]), 1e-300)
    ends = np.flatnonzero(rho <= 0)
    rho = rho[: ends[0]] if len(ends) else rho
    worth = number / (1.0 + 2.0 * float(np.sum(rho[1:] ** 2)))
    if worth < WORTH:
        return 1.0
    elsewhere = _elsewhere(x, y, counts, len(x) // 2 if apart is None else apart)
    both = float(x @ y)
    enough = ALIKE_APART if apart is None else STANDS_OUT
    if both - elsewhere.mean() < enough * elsewhere.std():
        return 1.0
    if apart is not None:
        both -= max(float(elsewhere.mean()), 0.0)
    z = both / max(float(noise[0]), 1e-300) * np.sqrt(worth)
    return float(scipy.stats.t.sf(z, worth - 1.0))


def _elsewhere(x: Array, y: Array, counts: Mask, period: int) -> Array:
    """What the sum of products would be parts of a period off the same place."""
    near, far = (max(1, round(share * period)) for share in ELSEWHERE)
    lags = np.arange(near, max(near, min(far, len(x) - 1)) + 1)
    there = counts.astype(float)
    pairs = np.maximum(_correlation(there, there)[lags], 1.0)
    sums = np.concatenate([_correlation(x, y)[lags] / pairs, _correlation(y, x)[lags] / pairs])
    return sums * there.sum()


def _correlation(x: Array, y: Array) -> Array:
    """(M,) sums of x(t + lag)·y(t) for lags from 0."""
    size = scipy.fft.next_fast_len(2 * len(x), real=True)
    product = scipy.fft.rfft(x, size) * np.conj(scipy.fft.rfft(y, size))
    return np.asarray(scipy.fft.irfft(product, size)[: len(x)])
