"""How much of a residual is the model's own: what motion predicts of it, noise does not.

What a model lacks is a function of the motion. It comes again whenever the joint is in the same
state, so however long a recording is, it holds no more independent values of that function than
there are states to tell apart. A standard error from the residual's spectrum alone counts every
minute as new evidence, and on real arms it is several times too small.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.measurement.signals import Lowpass
from pa10d.regression.equation import RunEquation
from pa10d.regression.spectrum import autocovariance, longest_lag, spectrum_of

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

LOOKS = 12.0  # independent values of what a model lacks, per joint: a smooth function of angle (in
# quarters of its range), direction and slow or fast has about as many
BLOCK = 4.0  # s: stretches that take turns as the two halves of the data
FEWEST_BLOCKS = 6
FEWEST_STATES = 6  # that both halves visit, to compare them at all
ALIKE = 0.7  # correlation of the halves' means: as much that comes again as does not
SURE = 2.0  # standard errors
UPPER = (0.5, 0.85)  # of the cut-off: where the residual's spectrum is taken as the noise's


@dataclass(frozen=True)
class Stretch:
    """Residual (M, n) N·m with the samples that count (M, n), and the motion behind it: rad, rad/s,
    rad/s² (M, n)."""

    residual: Array
    keep: NDArray[np.bool_]
    q: Array
    dq: Array
    ddq: Array

    @classmethod
    def of(cls, run: RunEquation, residual: Array, keep: NDArray[np.bool_]) -> Stretch:
        """What a fit leaves of a run, or of a piece of it. Copies: views would keep the raw motion
        of every piece in memory."""
        context, factor = run.context, run.lowpass.factor
        q, dq, ddq = (x[::factor].copy() for x in (context.q, context.dq, context.ddq))
        return cls(residual, keep, q, dq, ddq)


def lacking(stretches: Sequence[Stretch], lowpass: Lowpass) -> Array:
    """(n,) (N·m)²: mean square of each joint's residual that is not white noise, 0 where two halves
    of the data would show how it depends on the motion and do not agree: coloured noise."""
    n = stretches[0].residual.shape[1]
    rate = lowpass.rate / lowpass.factor
    out = np.zeros(n)
    quarters = _quarters(np.concatenate([s.q for s in stretches]))
    for j in range(n):
        if _never_comes_again(stretches, quarters, j, rate):
            continue
        own = [(s.residual[:, j], s.keep[:, j]) for s in stretches]
        gamma, count = autocovariance(own, longest_lag([len(k) for _, k in own], rate))
        f = np.linspace(0.0, 0.5 * rate, 512)
        gain = lowpass.gain(f)
        upper = (f > UPPER[0] * lowpass.cutoff) & (f < UPPER[1] * lowpass.cutoff)
        level = float(
            np.median(np.maximum(spectrum_of(gamma, f / rate), 0.0)[upper] / gain[upper] ** 2)
        )
        white = level * float(np.mean(gain**2))
        independent = max(2.0 * lowpass.cutoff * count / rate, 2.0)
        out[j] = max(float(gamma[0]) - white * (1.0 + SURE * np.sqrt(2.0 / independent)), 0.0)
    return out


def weight_of(lack: Array, samples: Array) -> Array:
    """(n,) (N·m)²: variance that each of ``samples`` (n,) would have were they independent, for the
    same doubt as LOOKS values of what is lacking leave."""
    return np.asarray(lack * np.maximum(samples / LOOKS, 1.0))


def _never_comes_again(
    stretches: Sequence[Stretch], quarters: Sequence[Labels], joint: int, rate: float
) -> bool:
    """Are the mean residuals of both halves of the data in the same states far from alike: by two
    standard errors over all states, by one in each kind of states, of which there is one for every
    joint, so that chance alone would find one that is?"""
    samples = sum(len(s.keep) for s in stretches)
    block = max(1, min(int(BLOCK * rate), samples // FEWEST_BLOCKS))
    halves = np.concatenate(
        [(np.arange(len(s.keep)) // block + k) % 2 for k, s in enumerate(stretches)]
    )
    keep = np.concatenate([s.keep[:, joint] for s in stretches])
    residual = np.concatenate([s.residual[:, joint] for s in stretches])[keep]
    first = halves[keep] == 0
    total, cells_seen = 0.0, 0
    for labels in _states(stretches, quarters, joint):
        seen = labels[keep]
        size = int(seen.max(initial=0)) + 1
        count = [np.bincount(seen[h], minlength=size) for h in (first, ~first)]
        both = (count[0] > 0) & (count[1] > 0)
        if both.sum() < FEWEST_STATES:
            return False
        means = [
            np.bincount(seen[h], residual[h], size)[both] / c[both]
            for h, c in zip((first, ~first), count, strict=True)
        ]
        size_of = np.minimum(*count)[both]
        alike = np.sum(size_of * means[0] * means[1])
        alike /= np.sqrt(np.prod([max(np.sum(size_of * m**2), 1e-300) for m in means]))
        cells = int(both.sum())
        if alike > _far_from_alike(cells, 1.0):
            return False
        total, cells_seen = total + cells * alike, cells_seen + cells
    return bool(total / cells_seen < _far_from_alike(cells_seen, SURE))


def _far_from_alike(cells: int, errors: float) -> float:
    """The correlation that is so many standard errors below ``ALIKE``, which estimated from m
    states has one of (1 - ALIKE²)/√m."""
    return ALIKE - errors * (1.0 - ALIKE**2) / float(np.sqrt(cells))


def _quarters(q: Array) -> list[Labels]:
    """Per joint (M,): in which quarter of its angles (M, n) it is."""
    return [np.searchsorted(np.quantile(a, (0.25, 0.5, 0.75)), a).astype(np.int64) for a in q.T]


def _states(
    stretches: Sequence[Stretch], quarters: Sequence[Labels], joint: int
) -> Iterator[Labels]:
    """Cells of a joint's own motion, then of its angle and each other joint's."""
    dq = np.concatenate([s.dq[:, joint] for s in stretches])
    speed = np.abs(dq)
    fast = (speed > np.median(speed)).astype(np.int64)
    yield 4 * quarters[joint] + 2 * (dq > 0) + fast
    for other, quarter in enumerate(quarters):
        if other != joint:
            yield 4 * quarters[joint] + quarter
