"""Motions that come again, within a run or in another one: there the model's error comes again
too, and what differs between the two passes is noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from pa10d.judgement.residuals import RunResidual

Array = NDArray[np.float64]

COARSE = 50.0  # Hz: enough to find when a motion comes again
SHORTEST = 1.0  # s of a period
LARGEST_SHIFT = 2.0  # s by which one run may be later in the motion than the other
ALIKE = 0.02  # largest difference of two passes, in standard deviations of a joint's motion
MOVES = 0.02  # rad: joints that move less do not decide
LEAST = 2.0  # s that two passes must have in common


@dataclass(frozen=True)
class Pass:
    """Filtered errors (K, n) N·m of two passes of one motion, sample by sample at the raw rate;
    counts (K, n): where both are judged; rate: Hz; cutoff: Hz of the low-pass; lag: samples
    from one to the other within a run, None for two runs."""

    one: Array
    other: Array
    counts: NDArray[np.bool_]
    rate: float
    cutoff: float
    lag: int | None

    @property
    def _step(self) -> int:
        return max(1, int(self.rate / (2.0 * self.cutoff)))

    @property
    def samples_apart(self) -> int | None:
        """The lag in samples of the band."""
        return None if self.lag is None else max(1, self.lag // self._step)

    def in_band(self, joint: int) -> tuple[Array, Array, NDArray[np.bool_]]:
        """One joint at twice the cut-off, where white noise stays white."""
        step = self._step
        return self.one[::step, joint], self.other[::step, joint], self.counts[::step, joint]


def passes(runs: list[RunResidual]) -> Iterator[Pass]:
    """Every motion that comes again: within a run a period later, or in another run."""
    fine = [run.equation.lowpass for run in runs]
    errors = [
        type(low)(low.samples, low.rate, low.cutoff, 1, low.order)(run.raw_error)
        for low, run in zip(fine, runs, strict=True)
    ]
    for i, run in enumerate(runs):
        rate, cutoff = fine[i].rate, fine[i].cutoff
        lag = period(run.seen.q, rate)
        if lag is not None:
            counts = run.raw_judged[lag:] & run.raw_judged[:-lag]
            yield Pass(errors[i][lag:], errors[i][:-lag], counts, rate, cutoff, lag)
        for k in range(i + 1, len(runs)):
            if abs(rate / fine[k].rate - 1.0) > 1e-3:
                continue
            shift = same_motion(run.seen.q, runs[k].seen.q, rate)
            if shift is not None:
                one, other = overlap(len(errors[i]), len(errors[k]), shift)
                counts = run.raw_judged[one] & runs[k].raw_judged[other]
                yield Pass(errors[i][one], errors[k][other], counts, rate, cutoff, None)


def differences(runs: list[RunResidual]) -> list[list[Array]]:
    """Per joint: differences of the filtered error (K,) N·m between two passes of one motion,
    over √2, so that their RMS is the noise's; empty where no motion comes again."""
    out: list[list[Array]] = [[] for _ in range(runs[0].error.shape[1])]
    for pair in passes(runs):
        for j, found in enumerate(out):
            counts = pair.counts[:, j]
            if counts.any():
                found.append((pair.one[counts, j] - pair.other[counts, j]) / np.sqrt(2.0))
    return out


def period(q: Array, rate: float) -> int | None:
    """Samples after which the motion (N, n) comes again; None where it never does."""
    step = max(1, int(rate / COARSE))
    x = q[::step]
    lags = np.arange(int(SHORTEST * rate / step), len(x) // 2)
    if len(lags) == 0:
        return None
    far = _distance(x, x)[lags]
    if not len(far) or far.min() > ALIKE**2:
        return None
    first = int(np.argmax(far < 4 * max(far.min(), 1e-12)))
    near = lags[first] * step + np.arange(-3 * step, 3 * step + 1)
    near = near[(near > 0) & (near < len(q))]
    exact = [float(np.max(_mean_square(q[lag:], q[:-lag]))) for lag in near]
    return int(near[int(np.argmin(exact))])


def same_motion(one: Array, other: Array, rate: float) -> int | None:
    """Samples by which ``other`` is later than ``one`` in the same motion; None where it is
    another motion."""
    reach = int(LARGEST_SHIFT * rate)
    step = max(1, int(rate / COARSE))
    best: tuple[float, int] = (np.inf, 0)
    for width, around in ((step, range(-reach, reach + 1, step)), (1, ())):
        tried = around or range(best[1] - step, best[1] + step + 1)
        for shift in tried:
            a, b = overlap(len(one), len(other), shift)
            if a.stop - a.start < max(LEAST * rate, 0.5 * max(len(one), len(other))):
                continue
            thin = (
                slice(None, None, max(1, (a.stop - a.start) // 400)) if width > 1 else slice(None)
            )
            far = float(np.max(_mean_square(one[a][thin], other[b][thin])))
            best = min(best, (far, shift))
    return best[1] if best[0] < ALIKE**2 else None


def overlap(one: int, other: int, shift: int) -> tuple[slice, slice]:
    """Which samples of two series belong together when the second is ``shift`` later."""
    start, other_start = max(0, -shift), max(0, shift)
    length = max(0, min(one - start, other - other_start))
    return slice(start, start + length), slice(other_start, other_start + length)


def _mean_square(one: Array, other: Array) -> Array:
    """(n,) mean squared difference in squares of each joint's spread; 0 for joints at rest."""
    spread = np.std(one, axis=0)
    far = np.mean((one - other) ** 2, axis=0) / np.maximum(spread, 1e-12) ** 2
    return np.where(spread > MOVES, far, 0.0)


def _distance(x: Array, y: Array) -> Array:
    """(L,) for each lag: the largest over joints of ``_mean_square`` of x later and y."""
    samples = len(x)
    size = scipy.fft.next_fast_len(2 * samples, real=True)
    x = x - x.mean(axis=0)
    spectrum = scipy.fft.rfft(x, size, axis=0)
    product = scipy.fft.irfft(np.abs(spectrum) ** 2, size, axis=0)[:samples]
    squares = np.concatenate([np.zeros((1, x.shape[1])), np.cumsum(x**2, axis=0)])
    lag = np.arange(samples)
    both = (squares[samples] - squares[lag]) + squares[samples - lag]
    far = (both - 2 * product) / (samples - lag)[:, None]
    variance = x.var(axis=0)
    moves = np.sqrt(variance) > MOVES
    if not moves.any():
        return np.full(samples, np.inf)
    return np.max(far[:, moves] / variance[moves], axis=1)
