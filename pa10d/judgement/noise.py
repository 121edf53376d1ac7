"""The error that a perfect model would leave: measurement noise within the band of the fit.

Three ways to see it. Where a motion comes again, the difference of the passes is noise and
nothing else. Where a joint stands still, its torque's wavering is. And above the cut-off, where
little motion reaches, the spectrum of torque or error (whichever is smaller there: one still has
motion in it, the other the noise of twice differentiated angles) is: white noise of that
strength would leave so much below. The last two are lower bounds (noise may be stronger in
motion, or at low frequencies), so the larger is taken where no motion comes again; but not a
standstill whose torque wavers more than the error in motion, because then it is creep or braking.
And never more than the error itself: friction that jumps at a reversal reaches above any cut-off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.jsonable import plain
from pa10d.judgement.repeats import differences
from pa10d.judgement.residuals import RunResidual
from pa10d.judgement.scores import moving, scores

Array = NDArray[np.float64]

REPEATS, STANDSTILL, ABOVE = "repeated motion", "standstill", "high frequencies"
FEWEST = 50  # samples of a difference
REST = 1.0  # s of standstill, at least
WINDOW = 6.0  # periods of the cut-off: of one look at a joint at rest
STILL = 1e-3  # of a joint's range: it may move this much and still stand
SECONDS = 1.0  # of one segment of the spectrum
BAND = (1.5, 4.0)  # cut-offs between which the error's spectrum is taken as the noise's


@dataclass(frozen=True)
class NoiseFloor:
    """values (n,) N·m, RMS behind the equation's low-pass; methods (n): how each was found."""

    values: Array
    methods: tuple[str, ...]

    def document(self) -> dict[str, Any]:
        """As JSON."""
        return {"noise_floor": plain(self.values), "noise_floor_from": list(self.methods)}


def noise_floor(runs: Sequence[RunResidual]) -> NoiseFloor:
    """Of several runs together, per joint the best way that they allow."""
    runs = list(runs)
    passes = differences(runs)
    values, methods = [], []
    for j, found in enumerate(passes):
        together = np.concatenate(found) if found else np.empty(0)
        if len(together) >= FEWEST:
            values.append(float(np.sqrt(np.mean(together**2))))
            methods.append(REPEATS)
            continue
        used = moving(runs, j)
        above = _pooled([_above(run, j) for run in used])
        rest, left = _pooled([_at_rest(run, j) for run in used]), float(scores(used).rms[j])
        rest = rest if rest < left else 0.0
        values.append(min(max(above, rest), left))
        methods.append(STANDSTILL if rest > above else ABOVE)
    return NoiseFloor(np.array(values), tuple(methods))


def _above(run: RunResidual, joint: int) -> tuple[float, int]:
    """Variance behind the low-pass of white noise as strong as error or torque are just above it,
    the median over segments, so that a knock does not count; and from how many segments."""
    lowpass = run.equation.lowpass
    length = min(len(run.raw_error), max(32, int(SECONDS * lowpass.rate)))
    counts = run.raw_counts[:, joint]
    starts = range(0, len(counts) - length + 1, length)
    segments = [slice(s, s + length) for s in starts if counts[s : s + length].all()]
    segments = segments or [slice(s, s + length) for s in starts]
    top = min(BAND[1] * lowpass.cutoff, 0.4 * lowpass.rate)
    levels = []
    for signal in (run.raw_error[:, joint], run.equation.raw_tau[:, joint]):
        f, power = scipy.signal.periodogram(
            np.array([signal[s] for s in segments]), lowpass.rate, window="hann", detrend="linear"
        )
        band = (f >= min(BAND[0] * lowpass.cutoff, 0.5 * top)) & (f <= top)
        levels.append(float(np.median(power[:, band].mean(axis=1))))
    level = min(levels)
    fine = np.linspace(0.0, 0.5 * lowpass.rate, 4000)
    return level * float(np.sum(lowpass.gain(fine) ** 2) * (fine[1] - fine[0])), len(segments)


def _at_rest(run: RunResidual, joint: int) -> tuple[float, int]:
    """Variance of the filtered torque about straight lines while the joint stands still, the
    median over short windows, and from how many samples.

    A servo that hunts within stiction winds its torque up and lets it go: within a window the
    winding is a line, and the median does not see the letting go.
    """
    settle = run.equation.lowpass.settle
    q = run.decimated(run.seen.q)[:, joint]
    reach = STILL * float(np.ptp(q))
    still = ~run.equation.moving[:, joint]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    length = max(8, round(WINDOW * run.equation.rate / run.equation.lowpass.cutoff))
    variances = []
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        start, stop = start + settle, stop - settle  # the filter still sees the motion there
        if stop - start < REST * run.equation.rate or np.ptp(q[start:stop]) > reach:
            continue
        for begin in range(start, stop - length + 1, length):
            rest = scipy.signal.detrend(run.measured[begin : begin + length, joint])
            variances.append(float(np.mean(rest**2)))
    # a line takes two of the 2·WINDOW independent values that a window has in the band
    share = 1.0 - 1.0 / WINDOW
    return (float(np.median(variances)) / share if variances else 0.0), len(variances) * length


def _pooled(parts: list[tuple[float, int]]) -> float:
    weight = sum(count for _, count in parts)
    return float(np.sqrt(sum(v * count for v, count in parts) / weight)) if weight else 0.0
