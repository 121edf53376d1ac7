"""The sign of a velocity, as friction takes it."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def smooth_sign(velocity: Array, v0: float) -> Array:
    """sign(v) smoothed over ±v0 and averaged over each sample interval.

    The mean of tanh(v/v0) while v goes linearly from the middle of the interval before to the
    middle of the one after; without the average a reversal within one sample is lost.
    velocity: (N,) rad/s. Returns (N,) in [-1, 1].
    """
    return _mean_tanh(np.ascontiguousarray(velocity, dtype=float), float(v0))


@numba.njit(cache=True, nogil=True)
def _mean_tanh(velocity, v0):
    samples = len(velocity)
    out = np.empty(samples)
    before, at_before, known = velocity[0], 0.0, False  # ln cosh of the interval's left end
    for k in range(samples):
        last = k == samples - 1
        after = velocity[k] if last else 0.5 * (velocity[k + 1] + velocity[k])
        span = after - before
        # beyond 20·v0 the tangent is ±1 to the last digit: only around reversals it costs anything
        if abs(before + after) - abs(span) >= 40.0 * v0:
            out[k], known = np.sign(before), False
        elif abs(span) < 1e-3 * v0:
            out[k], known = np.tanh(velocity[k] / v0), False
        else:
            if not known:
                at_before = _log_cosh(before / v0)
            at_after = _log_cosh(after / v0)
            out[k] = v0 * (at_after - at_before) / span
            at_before, known = at_after, True
        before = after
    return out


@numba.njit(cache=True, nogil=True)
def _log_cosh(x):
    a = abs(x)
    return a + np.log1p(np.exp(-2.0 * a)) - np.log(2.0)
