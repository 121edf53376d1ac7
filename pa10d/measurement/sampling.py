"""Sample times: are they equidistant, and if not, the values on a grid that is.

Encoders and current sensors are read at a fixed rate, but loggers stamp late, drop samples, write
a stamp twice or round it. Everything behind a recording wants equal steps.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError

Array = NDArray[np.float64]

STEADY = 0.01  # of a period: stamps this close to equal steps are taken as equal steps
GAP = 4.0  # periods without a sample: too long for a cubic to be trusted
MISSED = 0.05  # of a period: steps that are whole numbers of periods but for this lack samples
UNEVEN = 3.0  # ratio of neighbouring steps from which a cubic would amplify noise
LEAST_STEP = 1e-7  # s: nothing that reads a joint is as fast
LATEST = 9e9  # s: nanoseconds are counted in 64 bits
LARGEST_GRID = 1_000_000  # samples at equal steps that any recording may become
STRETCH = 20  # times as many samples as were measured, should that be more
LONG = 0.03  # s: ten straight lines of 25 ms cost a fit nothing, ten of 50 ms some 5 %
SETTLED = 0.5  # s of a recording that each stretch costs which is left out of it, or less
_BLOCK = 1 << 18


@dataclass(frozen=True)
class Timing:
    """What the stamps of a file say.

    ``grid`` starts at ``start`` with steps of ``period`` seconds and has ``length`` samples.
    ``resampled`` False: one sample per grid point, nothing was interpolated.
    """

    start: float
    period: float
    length: int
    resampled: bool
    jitter: float  # s, largest distance of a stamp from equal steps, gaps left out
    rounding: float | None  # s, where the stamps are equal steps rounded to this
    duplicates: int  # samples that share their stamp with the one before
    gaps: tuple[tuple[float, float], ...]  # (begin, seconds) without a sample
    missing: int = 0  # samples that equal steps would have had, gaps left out
    scatter: float = 0.0  # s, by which stamps were off steps that the positions show to be equal

    @property
    def rate(self) -> float:
        """Hz."""
        return 1.0 / self.period

    @property
    def uneven(self) -> bool:
        """Do steps differ, and not by samples that are missing?"""
        return self.resampled and not self.missing and self.jitter > STEADY * self.period

    @property
    def grid(self) -> Array:
        """(length,) s."""
        return self.start + self.period * np.arange(self.length, dtype=np.float64)

    @property
    def unmeasured(self) -> tuple[tuple[float, float], ...]:
        """(begin, end) of the gaps that no fit may use, s since the first sample: a straight line
        over q and τ obeys no equation of motion. None of them where so many lie in the recording
        that nothing would be left of it."""
        long = [(begin - self.start, span) for begin, span in self.gaps if span > LONG]
        measured = self.length * self.period - sum(span for _, span in long)
        if len(long) * SETTLED > measured:
            return ()
        return tuple((max(begin, 0.0), begin + span) for begin, span in long)


def merge_duplicates(t: Array) -> NDArray[np.int64] | None:
    """First index of every group of equal stamps; None where no two are equal.

    ``t`` (N,) s, never falling.
    """
    new = np.diff(t) > 0
    if new.all():
        return None
    return np.concatenate([[0], np.flatnonzero(new) + 1])


def merged(values: Array, starts: NDArray[np.int64] | None) -> Array:
    """Mean of each group of samples, (N,) or (N, n)."""
    if starts is None:
        return values
    sizes = np.diff(np.append(starts, len(values)))
    total = np.add.reduceat(values, starts, axis=0)
    return np.asarray(total / (sizes if values.ndim == 1 else sizes[:, None]))


def analyse(t: Array, duplicates: int = 0) -> Timing:
    """How the stamps ``t`` (N,) s, strictly rising, lie; N ≥ 2."""
    with np.errstate(over="ignore"):
        steps = np.diff(t)
    median = float(np.median(steps))
    if not median >= LEAST_STEP:
        raise UserError(f"found steps of {median:.3g} s, expected seconds; were they scaled?")
    _refuse_endless(t, steps, median)
    gaps = np.flatnonzero(steps > GAP * median)
    spans = tuple((float(t[k]), float(steps[k])) for k in gaps)
    period, offset = _line(t)
    rounding = _rounding(t, period)
    tolerance = max(STEADY * period, 0.75 * rounding if rounding else 0.0)
    period, offset = _simplest(t, period, offset, tolerance)
    off = float(np.abs(t - offset - period * np.arange(len(t))).max())
    if off <= tolerance:
        rounded = rounding if off > STEADY * period else None
        return Timing(offset, period, len(t), False, off, rounded, duplicates, spans)
    period = _round_rate(median, 0.02)
    length = int(np.floor((t[-1] - t[0]) / period * (1 + 1e-12))) + 1
    near = np.delete(steps, gaps)
    periods = np.maximum(np.rint(near / median), 1.0)
    late = np.abs(near - periods * median)
    if np.any(late > MISSED * median):  # and none left out
        periods, late = np.ones(len(near)), np.abs(near - median)
    jitter, missing = float(late.max(initial=0.0)), int(np.sum(periods - 1.0))
    return Timing(float(t[0]), period, length, True, jitter, None, duplicates, spans, missing)


def _refuse_endless(t: Array, steps: Array, median: float) -> None:
    """UserError where equal steps would be hundreds of times as many as there are samples: one
    wrong stamp, or recordings of different days in one file."""
    with np.errstate(over="ignore"):
        count, ratio = float((t[-1] - t[0]) / median) + 1, float(steps.max() / median)
    if not count <= max(LARGEST_GRID, STRETCH * len(t)):
        k = int(np.argmax(steps))
        raise UserError(
            f"found {t[k]:.9g} s and then {t[k + 1]:.9g} s, {ratio:.3g} times the usual "
            f"step of {median:.3g} s; expected one recording without such pauses (cut it there)"
        )
    if np.abs(t[[0, -1]]).max() > LATEST:
        raise UserError(f"found a stamp of {t[-1]:.9g} s, expected seconds within some centuries")


def _line(t: Array) -> tuple[float, float]:
    """Step and start of the equal steps that fit best."""
    k = np.arange(len(t)) - (len(t) - 1) / 2
    centre = float(t.mean())
    step = float(k @ (t - centre) / (k @ k))
    return step, centre - step * (len(t) - 1) / 2


def _rounding(t: Array, period: float) -> float | None:
    """The power of ten that all stamps are multiples of, if coarse enough to matter."""
    for exponent in range(0, 7):
        unit = 10.0**-exponent
        if 0.75 * unit <= STEADY * period:
            return None
        if unit <= period and np.abs(t / unit - np.rint(t / unit)).max() < 1e-3:
            return unit
    return None


def _simplest(t: Array, step: float, offset: float, tolerance: float) -> tuple[float, float]:
    """Equal steps from the first stamp at an integer rate, where the stamps agree with that."""
    simple = _round_rate(step, 1e-3)
    if np.abs(t - t[0] - simple * np.arange(len(t))).max() <= tolerance:
        return simple, float(t[0])
    return step, offset


def _round_rate(period: float, tolerance: float) -> float:
    """The period of the roundest rate nearby: what the logger was most likely told."""
    rate = 1.0 / period
    for unit in (1000, 500, 250, 100, 50, 25, 10, 5, 1):
        whole = round(rate / unit) * unit
        if whole and abs(rate - whole) <= tolerance * rate:
            return 1.0 / whole
    return period


class Resampler:
    """Values at irregular stamps, read off on the grid of a Timing.

    A cubic through the four nearest samples, the same for q, q̇ and τ: both sides of the equation
    of motion pass one kernel, whose gain at a tenth of the rate is above 0.99 where a straight
    line's falls to 0.95. Where the four stand unevenly a cubic would amplify noise, and across a
    gap it would invent motion: there, and for ``smooth=False``, a straight line.
    """

    def __init__(self, t: Array, timing: Timing) -> None:
        self._t = t
        self._timing = timing
        steps = np.diff(t)
        wide = np.concatenate([steps[:1], steps, steps[-1:]])
        trio = np.lib.stride_tricks.sliding_window_view(wide, 3)
        low, high = trio.min(axis=1), trio.max(axis=1)
        self._cubic = (high <= UNEVEN * low) & (steps <= GAP * np.median(steps))
        self._cubic[[0, -1]] = False  # no fourth sample beside the first and last step
        self._gap = steps > GAP * np.median(steps)

    def in_gap(self) -> Array:
        """(length,) 1 where the grid point stands in a gap, else 0."""
        return np.concatenate([self._gap[k] for k, _ in self._blocks()]).astype(float)

    def __call__(self, columns: Sequence[Array], smooth: bool = True) -> list[Array]:
        """Each (N,) column on the grid, (length,)."""
        out = [np.empty(self._timing.length) for _ in columns]
        at = 0
        for k, x in self._blocks():
            nodes, weights = self._weights(k, x, smooth)
            for column, target in zip(columns, out, strict=True):
                target[at : at + len(x)] = (column[nodes] * weights).sum(axis=0)
            at += len(x)
        return out

    def _blocks(self) -> Iterator[tuple[NDArray[np.int64], Array]]:
        """(index of the step that holds it, time) of the grid points, in blocks."""
        timing = self._timing
        for first in range(0, timing.length, _BLOCK):
            count = min(_BLOCK, timing.length - first)
            x = timing.start + timing.period * np.arange(first, first + count, dtype=np.float64)
            k = np.searchsorted(self._t, x, side="right").astype(np.int64) - 1
            yield np.clip(k, 0, len(self._t) - 2), x

    def _weights(
        self, k: NDArray[np.int64], x: Array, smooth: bool
    ) -> tuple[NDArray[np.int64], Array]:
        nodes = np.clip(k + np.arange(-1, 3)[:, None], 0, len(self._t) - 1)
        at = self._t[nodes]
        share = np.clip((x - at[1]) / (at[2] - at[1]), 0.0, 1.0)
        weights = np.zeros((4, len(x)))
        weights[1], weights[2] = 1 - share, share
        if smooth:
            cubic = self._cubic[k]
            at, x = at[:, cubic], x[cubic]
            for i in range(4):
                others = [j for j in range(4) if j != i]
                product = np.ones(len(x))
                for j in others:
                    product *= (x - at[j]) / (at[i] - at[j])
                weights[i, cubic] = product
        return nodes, weights
