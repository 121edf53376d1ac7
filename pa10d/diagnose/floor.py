"""How small the held-out error could get: the noise within the band of the equation."""

from __future__ import annotations

import numpy as np
import scipy.signal
from numpy.typing import NDArray

from pa10d.diagnose.state import State
from pa10d.equation import RunEquation

Array = NDArray[np.float64]

BAND = (1.5, 4.0)  # in multiples of the cut-off: above what the equation passes
SEGMENT_SECONDS = 0.5
FEWEST = 3


def noise_floor(state: State) -> Array:
    """(n,) N·m RMS that a perfect model would leave on the held-out side.

    White noise as strong as the unfiltered error just above the cut-off, in stretches of motion
    away from reversals, would leave this behind the low-pass. Noise that is stronger at low
    frequencies leaves more, so the true floor is this or higher.
    """
    n = state.held.n
    squares, weights = np.zeros(n), np.zeros(n)
    for run in state.held.runs:
        error = run.raw_tau - state.model.predict(run.context)
        for j in range(n):
            level, count = _level(run, error[:, j], j)
            squares[j] += level * count
            weights[j] += count
    known = weights > 0
    out = np.full(n, np.nan)
    out[known] = np.sqrt(squares[known] / weights[known])
    return out


def _level(run: RunEquation, error: Array, joint: int) -> tuple[float, int]:
    """Variance behind the low-pass that the error's level above it amounts to, and from how many
    segments; the median over segments, so that a knock in one does not count."""
    lowpass = run.lowpass
    keep = np.repeat(run.keep[:, joint], lowpass.factor)[: len(error)]
    length = max(16, int(SEGMENT_SECONDS * lowpass.rate))
    levels = []
    top = min(BAND[1] * lowpass.cutoff, 0.4 * lowpass.rate)
    for start in range(0, len(error) - length + 1, length):
        cut = slice(start, start + length)
        if not keep[cut].all():
            continue
        f, power = scipy.signal.periodogram(
            error[cut], lowpass.rate, window="hann", detrend="linear"
        )
        band = (f >= BAND[0] * lowpass.cutoff) & (f <= top)
        levels.append(float(np.mean(power[band])))
    if len(levels) < FEWEST:
        return 0.0, 0
    f = np.linspace(0.0, 0.5 * lowpass.rate, 2000)
    bandwidth = float(np.sum(lowpass.gain(f) ** 2) * (f[1] - f[0]))
    return float(np.median(levels)) * bandwidth, len(levels)
