"""Least squares of a sine at every order, for angles that are sampled unevenly.

The generalised Lomb-Scargle periodogram (Zechmeister & Kürster 2009: a sine, a cosine and a
constant at every order). Its sums are trigonometric moments, which are read off an FFT once the
samples are counted into fine bins of the angle (Press & Rybicki 1989).
"""

from __future__ import annotations

import numpy as np
import scipy.fft
from numpy.typing import NDArray

Array = NDArray[np.float64]

TURNS = 4  # orders are scanned in steps of 1/TURNS
ANGLE_BINS = 1 << 17  # over TURNS revolutions: order 1000 loses less than 1 % of its amplitude


def periodogram(q: Array, y: Array, order: Array) -> tuple[Array, Array]:
    """Share of y's variance that a sine of each order (multiples of 1/TURNS) takes, and its
    amplitude. q, y: (N,) rad and N·m; order: (K,) cycles/rev."""
    bins = np.rint(q * (ANGLE_BINS / (2 * np.pi * TURNS))).astype(np.int64) % ANGLE_BINS
    y = y - y.mean()
    weights = np.bincount(bins, minlength=ANGLE_BINS) / len(q)
    moments = np.bincount(bins, y, minlength=ANGLE_BINS) / len(q)
    at = np.rint(order * TURNS).astype(np.int64)
    ones, of_y = np.conj(scipy.fft.rfft(weights)), np.conj(scipy.fft.rfft(moments))
    c, s = ones[at].real, ones[at].imag
    cc = 0.5 * (1 + ones[2 * at].real) - c**2
    ss = 0.5 * (1 - ones[2 * at].real) - s**2
    cs = 0.5 * ones[2 * at].imag - c * s
    yc, ys = of_y[at].real, of_y[at].imag
    determinant = np.maximum(cc * ss - cs**2, 1e-12)
    a = (yc * ss - ys * cs) / determinant
    b = (ys * cc - yc * cs) / determinant
    variance = float(np.mean(y**2))
    return np.clip((a * yc + b * ys) / max(variance, 1e-300), 0.0, 1.0), np.hypot(a, b)
