"""Series that look like the error but know nothing of the motion.

Each has the error's values and, nearly, its spectrum, at random phases (amplitude-adjusted
Fourier surrogates; Theiler et al. 1992). What the error shows against the motion and they do not
is no accident, however slowly both vary and however heavy the error's tails are.
"""

from __future__ import annotations

import numpy as np
import scipy
import scipy.fft
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

COUNT = 100
_TURNS = np.exp(2j * np.pi * np.arange(4096) / 4096)  # phases fine enough, without the sines
_EULER = 0.5772156649015329


def surrogates(
    parts: list[tuple[Array, Mask]], rng: np.random.Generator, count: int = COUNT
) -> Array:
    """(K, count) for the K samples of several series (M,) that exist (mask True)."""
    values = np.concatenate([x[m] for x, m in parts])
    drawn = np.concatenate([_random_phases(x, m, rng, count) for x, m in parts])
    out = np.empty_like(drawn)
    ranked = np.sort(values)
    for k in range(count):
        out[np.argsort(drawn[:, k]), k] = ranked
    return out


def _random_phases(x: Array, exists: Mask, rng: np.random.Generator, count: int) -> NDArray:
    """Gaussian series with the spectrum of x's ranks, (number that exist, count). Gaps are
    bridged and the end is mirrored, because holes and a jump from end to start would look like
    fast variation, and surrogates that vary too fast make slow noise look like a finding."""
    at = np.flatnonzero(exists)
    ranks = scipy.stats.norm.ppf(scipy.stats.rankdata(x[exists]) / (len(at) + 1))
    bridged = np.interp(np.arange(at[0], at[-1] + 1), at, ranks)
    size = scipy.fft.next_fast_len(2 * len(bridged), real=True)
    gain = np.abs(scipy.fft.rfft(np.concatenate([bridged, bridged[::-1]]), size))
    out = np.empty((len(at), count), dtype=np.float32)
    for k in range(count):
        turns = _TURNS[rng.integers(0, len(_TURNS), len(gain), dtype=np.uint16)]
        out[:, k] = scipy.fft.irfft(gain * turns, size)[at - at[0]]
    return np.float32(np.std(x[exists])) * out


def chance(found: float, null: Array) -> float:
    """p of ``found`` among values that chance alone gave (S,), continued beyond the largest of
    them by Gumbel's law, which maxima obey."""
    scale = max(float(np.std(null, ddof=1)) * np.sqrt(6) / np.pi, 1e-12)
    middle = float(np.mean(null)) - _EULER * scale
    return float(-np.expm1(-np.exp(-(found - middle) / scale)))
