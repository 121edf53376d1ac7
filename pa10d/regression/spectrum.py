"""Autocovariance and spectrum of residuals with gaps, and Gram matrices under coloured errors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import scipy.fft
from numpy.typing import NDArray

Array = NDArray[np.float64]

LONGEST = 2.0  # s over which a residual may be correlated (decision 0174)


def longest_lag(lengths: Sequence[int], rate: float) -> int:
    """Samples over which residuals in stretches of these lengths are looked at for correlation."""
    return max(4, min(int(LONGEST * rate), max(lengths) // 4))


def autocovariance(
    stretches: Iterable[tuple[Array, NDArray[np.bool_]]], longest: int
) -> tuple[Array, int]:
    """γ (longest+1,) of residuals given as stretches of (values, mask), and the sample count.

    Each lag is averaged over the pairs of samples that both count.
    """
    products, pairs, total = np.zeros(longest + 1), np.zeros(longest + 1), 0
    for values, mask in stretches:
        length = scipy.fft.next_fast_len(len(values) + longest + 1, real=True)
        counted = scipy.fft.rfft(mask.astype(float), length)
        there = scipy.fft.rfft(np.where(mask, values, 0.0), length)
        products += scipy.fft.irfft(np.abs(there) ** 2, length)[: longest + 1]
        pairs += scipy.fft.irfft(np.abs(counted) ** 2, length)[: longest + 1]
        total += int(mask.sum())
    return products / np.maximum(pairs, 1.0), total


def correlation_length(gamma: Array, samples: int) -> int:
    """Lag from which on the autocorrelation is no larger than chance (Politis 2003)."""
    if gamma[0] <= 0 or samples < 10:
        return 1
    chance = 2.0 * np.sqrt(np.log10(samples) / samples)
    quiet = max(5, int(np.sqrt(np.log10(samples))))
    small = np.abs(gamma[1:] / gamma[0]) < chance
    run = 0
    for lag, value in enumerate(small, start=1):
        run = run + 1 if value else 0
        if run == quiet:
            return max(1, lag - quiet)
    return max(1, len(gamma) // 2)


def flat_top(gamma: Array, length: int) -> Array:
    """γ tapered: whole up to ``length``, linearly to zero at twice that."""
    lags = np.arange(len(gamma))
    return gamma * np.clip(2.0 - lags / max(length, 1), 0.0, 1.0)


def colour(stretches: Sequence[tuple[Array, NDArray[np.bool_]]], rate: float) -> Array:
    """γ (L+1,) of residuals, tapered beyond the lag from which on it is chance."""
    gamma, count = autocovariance(stretches, longest_lag([len(k) for _, k in stretches], rate))
    return flat_top(gamma, correlation_length(gamma, count))


def spectrum_of(gamma: Array, frequency: Array) -> Array:
    """Two-sided density per sample at ``frequency`` (F,) cycles per sample, γ tapered by a Hann
    window (Blackman and Tukey 1958)."""
    lags = np.arange(1, len(gamma))
    taper = 0.5 * (1.0 + np.cos(np.pi * lags / len(gamma)))
    turned = np.cos(2.0 * np.pi * np.outer(frequency, lags))
    return np.asarray(gamma[0] + 2.0 * turned @ (gamma[1:] * taper))


def coloured_gram(columns: Array, gamma: Array) -> Array:
    """Σ_t Σ_s x_t·γ(|t-s|)·x_sᵀ (k, k) for columns (M, k) that are zero where nothing counts."""
    lags = len(gamma) - 1
    length = scipy.fft.next_fast_len(len(columns) + lags + 1, real=True)
    kernel = np.zeros(length)
    kernel[: lags + 1] = gamma
    kernel[length - lags :] = gamma[:0:-1]
    spectrum = np.maximum(scipy.fft.rfft(kernel).real, 0.0)
    spectrum[1:] *= 2.0
    if length % 2 == 0:
        spectrum[-1] /= 2.0
    turned = scipy.fft.rfft(np.ascontiguousarray(columns.T), length, axis=1)
    turned *= np.sqrt(spectrum / length)
    return np.asarray(turned.real @ turned.real.T + turned.imag @ turned.imag.T)
