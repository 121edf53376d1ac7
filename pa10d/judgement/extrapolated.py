"""What a spectrum above a band says of the noise within it: white noise, behind some smoothing.

Which smoothing it was shows in the spectrum itself: notches at multiples of one frequency, or how
it rolls off. Every usual one is held against it (Whittle's likelihood; a line that stands out of a
spectrum is no noise), and counts by how well it fits. Before anything was seen, none at all is as
likely as all of them together; and nothing is surer than the best fit is good. What they leave
within the band is averaged, and where they differ there, that is the uncertainty. Where the noise
may roll off within the band, where nobody can see it, nothing is said.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.judgement.smoothing import shapes
from pa10d.measurement.signals import Lowpass

Array = NDArray[np.float64]

HANN = 2.0 / 3.0  # independent values per ordinate behind this window
MEDIAN = float(np.log(2.0)) ** 2  # of the looks, that a median of exponential ordinates is worth
AROUND = 9  # ordinates by which the weaker of two signals is told
LINES = 0.01  # of the ordinates that hold a line or an image of the motion
DYNAMIC = float(np.log(1e6))  # range of what a line may have, in powers of e
CLOSEST = 500  # shapes that are looked at twice: of all, no more than a dozen may fit
UNSEEN = 0.05  # largest chance that the noise rolls off within the band
DEEPEST = 1e-4  # of the strongest ordinate: what is weaker, a window lets through from elsewhere
NEXT = 0.1  # of the ordinates, that lie next to the band
STEEPEST = 16.0  # times: a drive's own filter of first or second order costs four; what rolls off
# by more, and has no notches, may be no noise but what the motion leaves
FAR = 4.0  # times where one begins to look: what is flat up to there is not what the motion leaves
BELOW = 0.1  # of what was smoothed, next to the band: more white noise beside it hides which of the
# two was slow
STEPS = 3  # of the level among ordinates of which some hold lines


@dataclass(frozen=True)
class Extrapolated:
    """variance (N·m)² behind a low-pass, and its relative standard error."""

    variance: float
    error: float


def extrapolated(
    power: Array, length: int, used: NDArray[np.bool_], lowpass: Lowpass, repeated: float = 1.0
) -> Extrapolated | None:
    """None where these do not tell.

    power (signals, segments, f): periodograms (Hann, one-sided density) of stretches of ``length``
    samples, of signals that hold one noise and more besides; used (f,): ordinates above the band;
    repeated: how often each value comes, on average: above 1 the spectrum repeats itself, too.
    """
    known = shapes(length, lowpass.rate, lowpass.cutoff, lowpass.order)
    seen = _least(power[:, :, used])
    deep = seen <= DEEPEST * seen.max()
    seen, at = seen[~deep], np.flatnonzero(used)[~deep]
    worth = max(1.0, MEDIAN * power.shape[1]) * HANN
    number = max(1.0, len(at) / max(1.0, repeated))
    expected = known.expected[:, at]
    level, fits = _fits(seen, expected, worth, known.white <= BELOW * expected[:, 0])
    fits *= number / len(at)
    best = int(np.argmax(fits))
    ratio = seen / (level[best] * expected[best])
    spread = _spread(ratio, worth)
    likely = fits / spread + np.log(known.prior)
    weight = np.exp(likely - likely.max())
    weight /= weight.sum()
    edge = float(at[0]) * lowpass.rate / length
    steep = expected[:, 0] > STEEPEST * expected[:, -1]
    rolls = np.isfinite(known.knee) & (known.knee < FAR * edge) & steep
    if weight[rolls | (known.knee < edge)].sum() > UNSEEN:
        return None
    inside = np.log(level * known.passed)
    mean = float(weight @ inside)
    doubts = (
        float(weight @ (inside - mean) ** 2),
        spread / (worth * number),
        _beside(ratio) ** 2,
    )
    return Extrapolated(float(np.exp(mean)), float(np.sqrt(sum(doubts))))


def _beside(ratio: Array) -> float:
    """By how much the ordinates next to the band (f,), of which half are no lines, are not what
    the best shape says."""
    near = ratio[: max(1, round(NEXT * len(ratio)))]
    return abs(float(np.median(near)) - 1.0)


def _least(power: Array) -> Array:
    """(f,) means of the weaker signal by medians over segments, so that a knock does not count;
    which one that is, its surroundings tell: the least of two chances is no fair one."""
    k = np.arange(1, (power.shape[1] + 1) // 2)
    mean = np.median(power, axis=1) / (1.0 + float(np.sum(1.0 / (2 * k + 1) - 1.0 / (2 * k))))
    around = scipy.ndimage.uniform_filter1d(mean, AROUND, axis=1, mode="nearest")
    return np.take_along_axis(mean, around.argmin(axis=0)[None], axis=0)[0]


def _fits(
    seen: Array, expected: Array, worth: float, allowed: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """(m,) level and log-likelihood of every shape (m, f); none of those that are not allowed, or
    farther than others from the spectrum on a logarithmic scale. The first is always asked."""
    apart = np.log(seen) - np.log(expected)
    far = np.einsum("mf,mf->m", apart, apart) - apart.shape[1] * apart.mean(axis=1) ** 2
    far = np.where(allowed, far, np.inf)
    far[0] = -np.inf
    near = np.argsort(far)[: min(CLOSEST, int(allowed.sum()))]
    level, fits = np.exp(apart.mean(axis=1)), np.full(len(expected), -np.inf)
    level[near] = np.median(seen / expected[near], axis=1)
    for _ in range(STEPS):
        ratio = seen / (level[near, None] * expected[near])
        fits[near], noise = _likelihood(ratio, worth)
        level[near] *= np.sum(noise * ratio, axis=1) / np.maximum(np.sum(noise, axis=1), 1e-9)
    return level, fits


def _likelihood(ratio: Array, worth: float) -> tuple[Array, Array]:
    """(m,) log-likelihoods of ordinates (m, f) over what is expected, on a logarithmic scale, and
    (m, f) the chance that each is noise alone."""
    log = np.log(np.maximum(ratio, 1e-300))
    peak = worth * np.log(worth) - float(scipy.special.gammaln(worth))
    noise = np.log1p(-LINES) + peak + worth * (log - ratio)
    line = np.where(ratio > 1.0, np.log(LINES / DYNAMIC), -np.inf)
    both = np.logaddexp(noise, line)
    return both.sum(axis=1), np.exp(noise - both)


def _spread(ratio: Array, worth: float) -> float:
    """How many times more than by chance the ordinates (f,) scatter about the best shape; at least
    once."""
    noise = _likelihood(ratio[None], worth)[1][0]
    return max(1.0, worth * float(noise @ (ratio - 1.0) ** 2) / max(1.0, float(noise.sum()) - 3.0))
