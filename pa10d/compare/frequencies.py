"""Power of the error against frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.judgement.residuals import RunResidual
from pa10d.judgement.scores import moving

Array = NDArray[np.float64]

SECONDS = 4.0  # of one segment: lines a quarter of a hertz apart are still told apart


@dataclass(frozen=True)
class FrequencySpectrum:
    """frequency (F,) Hz; error, torque (F,) N·m/√Hz, root of the one-sided power density of the
    unfiltered error and of the unfiltered measured torque."""

    frequency: Array
    error: Array
    torque: Array


def frequency_spectrum(runs: list[RunResidual], joint: int) -> FrequencySpectrum:
    """Welch's mean over all runs; samples that do not count are silent and made up for."""
    used = moving(runs, joint)
    rate = min(run.equation.lowpass.rate for run in used)
    length = int(min(SECONDS * rate, *(len(run.raw_error) for run in used)))
    grid = np.arange(length // 2 + 1, dtype=float) * (rate / length)
    total = np.zeros((2, len(grid)))
    weight = 0.0
    for run in used:
        counts = run.raw_counts[:, joint]
        share, seconds = float(counts.mean()), len(counts) / run.equation.lowpass.rate
        for row, signal in enumerate((run.raw_error[:, joint], run.equation.raw_tau[:, joint])):
            level = float(signal[counts].mean())
            quiet = np.where(counts, signal - level, 0.0)
            nperseg = min(len(quiet), int(SECONDS * run.equation.lowpass.rate))
            f, power = scipy.signal.welch(quiet, run.equation.lowpass.rate, nperseg=nperseg)
            total[row] += np.interp(grid, f, power) / share * seconds
        weight += seconds
    density = np.sqrt(total / weight)
    return FrequencySpectrum(grid[1:], density[0, 1:], density[1, 1:])
