"""Does an error come again where the motion does? Noise does not, whatever its colour.

Two passes of one motion have the model's error in common; their difference has noise alone. So the
difference says how the noise goes on from sample to sample (an autoregression), and both passes
are whitened by it: of what is left, each sample tells something new, however slow the noise was,
and what noise remembers of an earlier pass within a run is gone. Then the sum of two passes is as
strong as their difference where there is noise alone: Fisher's ratio of variances.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

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
ORDER = 4  # of the autoregression: what is white, and two memories beside it
BLOCK = 200  # samples of the band in which level and drift are nobody's, and whitening is one step
SPECTRUM = 4096  # frequencies at which the autoregression's spectrum is taken
STEADY = 0.999  # largest partial correlation: an autoregression that does not run away
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
    return [of_joint(found, j) for j in range(runs[0].error.shape[1])]


def of_joint(found: Sequence[Pass], joint: int) -> Repeatable | None:
    """What these passes say of one joint (0-based); None where they have too little in common."""
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
    difference = np.where(counts, one - other, 0.0)
    gamma = _going_on(difference - np.where(counts, difference[counts].mean(), 0.0), counts)
    if gamma is None:
        return 1.0
    x, y, known = _whitened(np.column_stack([one, other]), counts, gamma, apart or BLOCK)
    number = float(known.sum())
    noise = _correlation(x - y, x - y)[: max(2, len(x) // 4)]
    rho = noise / max(float(noise[0]), 1e-300)
    ends = np.flatnonzero(rho <= 0)
    rho = rho[: ends[0]] if len(ends) else rho
    worth = number / (1.0 + 2.0 * float(np.sum(rho[1:] ** 2)))
    if worth < max(WORTH, 2.0 * ORDER):
        return 1.0
    both = float(x @ y)
    if apart is not None:  # what slow noise remembers of a pass it remembers of the moments around
        both -= max(float(_elsewhere(x, y, known, apart).mean()), 0.0)
    alike = both / max(0.5 * float(x @ x + y @ y), 1e-300)
    # whitening was fitted to the difference and not to the sum (Akaike's final prediction error)
    ratio = (1.0 + alike) / max(1.0 - alike, 1e-12) * (number - ORDER) / (number + ORDER)
    return float(scipy.stats.f.sf(ratio, worth, worth))


def _going_on(noise: Array, counts: Mask) -> Array | None:
    """Autocovariance (SPECTRUM,) of the autoregression that goes on as the noise (M,) does
    (Levinson and Durbin); None where there is no noise."""
    there = counts.astype(float)
    gamma = _correlation(noise, noise)[: ORDER + 1] / np.maximum(
        _correlation(there, there)[: ORDER + 1], 1.0
    )
    if not gamma[0] > 0:
        return None
    weights, left = np.empty(0), float(gamma[0])
    for k in range(1, ORDER + 1):
        partial = (gamma[k] - weights @ gamma[1:k][::-1]) / left
        partial = float(np.clip(partial, -STEADY, STEADY))
        weights = np.append(weights - partial * weights[::-1], partial)
        left *= 1.0 - partial**2
    power = 1.0 / np.abs(scipy.fft.rfft(np.append(1.0, -weights), 2 * SPECTRUM)) ** 2
    return np.asarray(scipy.fft.irfft(power)[:SPECTRUM])


def _whitened(series: Array, counts: Mask, gamma: Array, block: int) -> tuple[Array, Array, Mask]:
    """Two series (M, 2) as innovations of noise with autocovariance gamma, gaps heeded, level and
    drift of each block taken out; zero where the third says that nothing is known."""
    out, known = np.zeros_like(series), np.zeros(len(series), dtype=bool)
    number = max(1, round(len(series) / min(block, BLOCK)))
    edges = np.linspace(0, len(series), number + 1).astype(int)
    for start, stop in pairwise(edges):
        at = start + np.flatnonzero(counts[start:stop])
        if len(at) < 2 * ORDER:
            continue
        noise = gamma[np.abs(at[:, None] - at)] + 1e-9 * gamma[0] * np.eye(len(at))
        level = np.column_stack([np.ones(len(at)), at - at.mean()])
        white = scipy.linalg.solve_triangular(
            np.linalg.cholesky(noise), np.column_stack([level, series[at]]), lower=True
        )
        basis = np.linalg.qr(white[:, :2])[0]
        out[at] = white[:, 2:] - basis @ (basis.T @ white[:, 2:])
        known[at] = True
    return out[:, 0], out[:, 1], known


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
