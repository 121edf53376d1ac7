"""How many independent observations a correlated series is worth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Autocorrelation:
    """rho (L,) from lag 0 on, of samples that exist; pairs (L,): how many pairs each lag has."""

    rho: Array
    pairs: Array
    samples: int

    @property
    def time(self) -> float:
        """Integrated autocorrelation time in samples, at least 1 (Geyer's initial positive
        sequence: sums of neighbouring lags are added until one is negative)."""
        even = len(self.rho) // 2 * 2
        sums = self.rho[:even].reshape(-1, 2).sum(axis=1)
        end = np.flatnonzero(sums <= 0)
        kept = sums[: end[0]] if len(end) else sums
        return float(max(1.0, 2.0 * kept.sum() - 1.0))

    @property
    def effective(self) -> float:
        """Number of independent samples that fix the mean as well."""
        return self.samples / self.time


def autocorrelation(parts: list[tuple[Array, Mask]], lags: int) -> Autocorrelation:
    """Of several series (M,) with gaps (mask False), about their common mean."""
    mean = sum(float(x[m].sum()) for x, m in parts) / max(1, sum(int(m.sum()) for _, m in parts))
    products, pairs = np.zeros(lags), np.zeros(lags)
    for x, m in parts:
        size = scipy.fft.next_fast_len(2 * len(x), real=True)
        for values, total in ((np.where(m, x - mean, 0.0), products), (m.astype(float), pairs)):
            power = np.abs(scipy.fft.rfft(values, size)) ** 2
            found = scipy.fft.irfft(power, size)[: min(lags, len(x))]
            total[: len(found)] += found
    pairs = np.rint(pairs)
    covariance = products / np.maximum(pairs, 1.0)
    variance = covariance[0] if covariance[0] > 0 else 1.0
    rho = np.where(pairs > 0, covariance / variance, 0.0)
    return Autocorrelation(rho, pairs, int(pairs[0]))
