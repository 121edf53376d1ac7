"""What a spectrum above a band says of the noise within it: white noise, behind some smoothing.

Which smoothing it was shows in the spectrum itself: notches at multiples of one frequency, or how
it rolls off. Every usual one is held against it (Whittle's likelihood; a line that stands out of a
spectrum is no noise), and counts by how well it fits. Before anything was seen, none at all is as
likely as all of them together; and nothing is surer than the best fit is good. One smoothing is
that of all channels of a robot, but for those that have their own or show no noise, so that they
tell together what each is too short to tell. What all leave within the band is averaged, and where
they differ there, that is the uncertainty. Where the noise may roll off within the band, where
nobody can see it, nothing is said.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.judgement.smoothing import Shapes, shapes
from pa10d.measurement.signals import Lowpass

Array = NDArray[np.float64]
Names = NDArray[np.int64]

HANN = 2.0 / 3.0  # independent values per ordinate behind this window
MEDIAN = float(np.log(2.0)) ** 2  # of the looks, that a median of exponential ordinates is worth
AROUND = 9  # ordinates by which the weaker of two signals is told
LINES = 0.01  # of the ordinates that hold a line or an image of the motion
DYNAMIC = float(np.log(1e6))  # range of what a line may have, in powers of e
CLOSEST = 500  # shapes that are looked at twice: of all, no more than a dozen may fit
ALIKE = 100  # smoothings, each with more or less white noise beside it, for all channels at once
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


@dataclass(frozen=True)
class Look:
    """A channel's spectrum above the band, in one run.

    edge Hz, where it begins; at (f,): the ordinates, seen (f,): what they hold, as worth
    exponential ones (each) and as number independent ones (all of them); far (m,): of each shape
    """

    known: Shapes
    edge: float
    at: NDArray[np.intp]
    seen: Array
    worth: float
    number: float
    far: Array


@dataclass(frozen=True)
class _Fitted:
    """level (m,): of each shape; likely (m,): logarithm of its likelihood times its prior; ratio
    (f,): the spectrum over the best of them; spread: how many times more than by chance it
    scatters."""

    level: Array
    likely: Array
    ratio: Array
    spread: float


def looked_at(
    power: Array, length: int, used: NDArray[np.bool_], lowpass: Lowpass, repeated: float = 1.0
) -> Look:
    """power (signals, segments, f): periodograms (Hann, one-sided density) of stretches of
    ``length`` samples, of signals that hold one noise and more besides; used (f,): ordinates above
    the band; repeated: how often each value comes, on average: above 1 the spectrum repeats itself,
    too."""
    known = shapes(length, lowpass.rate, lowpass.cutoff, lowpass.order)
    seen = _least(power[:, :, used])
    deep = seen <= DEEPEST * seen.max()
    seen, at = seen[~deep], np.flatnonzero(used)[~deep]
    expected = known.expected[:, at]
    return Look(
        known=known,
        edge=float(at[0]) * lowpass.rate / length,
        at=at,
        seen=seen,
        worth=max(1.0, MEDIAN * power.shape[1]) * HANN,
        number=max(1.0, len(at) / max(1.0, repeated)),
        far=_far(seen, expected, known.white <= BELOW * expected[:, 0]),
    )


def extrapolated(looks: Sequence[Look]) -> list[Extrapolated | None]:
    """Of each look at channels of one rate; None where these do not tell."""
    alike = _most_alike(looks)
    fitted = [_fitted(look, alike) for look in looks]
    return [
        _within(look, fit, weight)
        for look, fit, weight in zip(looks, fitted, _weights(looks, fitted, alike), strict=True)
    ]


def _within(look: Look, fit: _Fitted, weight: Array) -> Extrapolated | None:
    known = look.known
    steep = known.expected[:, look.at[0]] > STEEPEST * known.expected[:, look.at[-1]]
    rolls = np.isfinite(known.knee) & (known.knee < FAR * look.edge) & steep
    if weight[rolls | (known.knee < look.edge)].sum() > UNSEEN:
        return None
    inside = np.log(fit.level * known.passed)
    mean = float(weight @ inside)
    doubts = (
        float(weight @ (inside - mean) ** 2),
        fit.spread / (look.worth * look.number),
        _beside(fit.ratio) ** 2,
    )
    return Extrapolated(float(np.exp(mean)), float(np.sqrt(sum(doubts))))


def _most_alike(looks: Sequence[Look]) -> Names:
    """The smoothings that come nearest to all of these spectra at once, if it is one for all."""
    names = reduce(np.intersect1d, {id(k.known): k.known.names for k in looks}.values())
    apart = np.zeros(len(names))
    for look in looks:
        nearest = np.full(len(look.known.names), np.inf)
        np.minimum.at(nearest, look.known.place, look.far)
        nearest = nearest[np.searchsorted(look.known.names, names)]
        apart += nearest * look.worth * look.number / len(look.at)
    return np.asarray(np.sort(names[np.argsort(apart)[:ALIKE]]))


def _fitted(look: Look, alike: Names) -> _Fitted:
    """Of those shapes that come near to this look or to all of them."""
    near = np.zeros(len(look.far), dtype=bool)
    near[np.argsort(look.far)[:CLOSEST]] = True
    near = (near | (_places(look.known, alike) >= 0)) & (look.far < np.inf)
    expected = look.known.expected[:, look.at]
    level, fits = _fits(look.seen, expected, look.worth, np.flatnonzero(near))
    fits *= look.number / len(look.at)
    best = int(np.argmax(fits))
    ratio = look.seen / (level[best] * expected[best])
    spread = _spread(ratio, look.worth)
    return _Fitted(level, fits / spread + np.log(look.known.prior), ratio, spread)


def _weights(looks: Sequence[Look], fitted: Sequence[_Fitted], alike: Names) -> list[Array]:
    """(m,) of each look: how likely each shape is. One kind of electronics smooths all channels of
    a robot, or one is behind something else, or shows what is no noise: before anything was seen,
    each of them is as likely one of all as not. How much white noise there is from behind the
    smoothing each has for itself."""
    own = [scipy.special.logsumexp(fit.likely) for fit in fitted]
    each = [np.exp(fit.likely - whole) for fit, whole in zip(fitted, own, strict=True)]
    if len(looks) == 1:
        return each
    places = [_places(look.known, alike) for look in looks]
    before = [
        _summed(np.log(look.known.prior), at, alike) for look, at in zip(looks, places, strict=True)
    ]
    named = [_summed(fit.likely, at, alike) for fit, at in zip(fitted, places, strict=True)]
    better = [n - b - whole for n, b, whole in zip(named, before, own, strict=True)]
    common = scipy.special.softmax(before[0] + sum(np.logaddexp(0.0, one) for one in better))
    out = []
    for fit, at, by_name, alone, one in zip(fitted, places, named, each, better, strict=True):
        belongs = common * scipy.special.expit(one)
        with np.errstate(divide="ignore"):
            share = np.append(np.log(belongs) - by_name, -np.inf)[at]
        out.append(np.exp(share + fit.likely) + (1.0 - belongs.sum()) * alone)
    return out


def _places(known: Shapes, wanted: Names) -> NDArray[np.intp]:
    """(m,) where each shape's smoothing is among those that are wanted (sorted); -1: nowhere."""
    at = np.minimum(np.searchsorted(wanted, known.names), len(wanted) - 1)
    return np.where(wanted[at] == known.names, at, -1)[known.place]


def _summed(log: Array, places: NDArray[np.intp], wanted: Names) -> Array:
    """(wanted,) logarithms of the sums over all shapes of one name."""
    top = np.full(len(wanted), -np.inf)
    here = np.flatnonzero((places >= 0) & (log > -np.inf))
    np.maximum.at(top, places[here], log[here])
    parts = np.exp(log[here] - top[places[here]])
    with np.errstate(divide="ignore"):
        return top + np.log(np.bincount(places[here], parts, len(wanted)))


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


def _far(seen: Array, expected: Array, allowed: NDArray[np.bool_]) -> Array:
    """(m,) how far every shape (m, f) is from the spectrum on a logarithmic scale; inf where it is
    not allowed. The first always is."""
    apart = np.log(seen) - np.log(expected)
    far = np.einsum("mf,mf->m", apart, apart) - apart.shape[1] * apart.mean(axis=1) ** 2
    far = np.where(allowed, far, np.inf)
    far[0] = -1.0
    return np.asarray(far)


def _fits(
    seen: Array, expected: Array, worth: float, near: NDArray[np.intp]
) -> tuple[Array, Array]:
    """(m,) level and log-likelihood of every shape (m, f); -inf of those that are not near."""
    level = np.exp((np.log(seen) - np.log(expected)).mean(axis=1))
    fits = np.full(len(expected), -np.inf)
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
