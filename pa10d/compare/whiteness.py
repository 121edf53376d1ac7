"""Is what is left of the torque white noise within the band that was fitted?

A low-passed residual is correlated by its filter, whatever it was before. So the raw error is cut
to the band below the cut-off by an ideal low-pass and sampled at twice the cut-off, where
white noise stays white; on those samples Ljung and Box's portmanteau is honest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
import scipy.fft
from numpy.typing import NDArray

from pa10d.compare.correlation import autocorrelation
from pa10d.judgement.residuals import RunResidual
from pa10d.judgement.scores import moving

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

LAG_SECONDS = 1.0  # correlation further apart is not asked for


@dataclass(frozen=True)
class Whiteness:
    """p_value of Ljung-Box over ``lag`` (L,) s; rho (L,) autocorrelation from lag 0
    samples: of the band; effective: independent ones that they are worth
    memory: s, integrated autocorrelation time (one sample of the band for white noise)"""

    lag: Array
    rho: Array
    p_value: float
    samples: int
    effective: float
    memory: float


def whiteness(runs: list[RunResidual], joint: int) -> Whiteness:
    """Of one joint over all runs."""
    used = moving(runs, joint)
    rate = 2 * min(run.equation.lowpass.cutoff for run in used)
    parts = [
        in_band(
            run.raw_error[:, joint],
            run.raw_counts[:, joint],
            round(len(run.raw_error) * rate / run.equation.lowpass.rate),
        )
        for run in used
    ]
    shortest = min(len(x) for x, _ in parts)
    lags = int(np.clip(LAG_SECONDS * rate, 2, max(2, shortest // 4)))
    found = autocorrelation(parts, lags + 1)
    n, pairs = found.samples, np.maximum(found.pairs[1:], 1.0)
    # without gaps, pairs = n - lag and this is Ljung and Box's n(n+2)·Σ r²/(n-lag)
    statistic = (n + 2) / n * float(np.sum(pairs * found.rho[1:] ** 2))
    return Whiteness(
        lag=np.arange(lags + 1) / rate,
        rho=found.rho,
        p_value=float(scipy.stats.chi2.sf(statistic, lags)),
        samples=n,
        effective=found.effective,
        memory=found.time / rate,
    )


def in_band(signal: Array, counts: Mask, samples: int) -> tuple[Array, Mask]:
    """(N,) -> (samples,): cut to the band that ``samples`` values can hold, without a shoulder."""
    quiet = np.where(counts, signal - signal[counts].mean(), 0.0)
    spectrum = scipy.fft.rfft(quiet)[: samples // 2 + 1]
    kept = scipy.fft.irfft(spectrum, samples) * (samples / len(signal))
    at = np.minimum(np.arange(samples) * len(signal) // samples, len(signal) - 1)
    return kept, counts[at]
