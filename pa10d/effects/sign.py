"""The sign of a velocity, as friction takes it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def smooth_sign(velocity: Array, v0: float) -> Array:
    """sign(v) smoothed over ±v0 and averaged over each sample interval.

    The mean of tanh(v/v0) while v goes linearly from the middle of the interval before to the
    middle of the one after; without the average a reversal within one sample is lost.
    velocity: (N,) rad/s. Returns (N,) in [-1, 1].
    """
    middle = 0.5 * (velocity[1:] + velocity[:-1])
    before = np.concatenate([velocity[:1], middle])
    after = np.concatenate([middle, velocity[-1:]])
    out = np.sign(before)
    # beyond 20·v0 the tangent is ±1 to the last digit: only the neighbourhood of reversals costs
    near = np.flatnonzero((np.abs(before + after) - np.abs(after - before)) < 40.0 * v0)
    before, after = before[near], after[near]
    span = after - before
    small = np.abs(span) < 1e-3 * v0
    safe = np.where(small, 1.0, span)
    mean = v0 * (_log_cosh(after / v0) - _log_cosh(before / v0)) / safe
    out[near] = np.where(small, np.tanh(velocity[near] / v0), mean)
    return out


def _log_cosh(x: Array) -> Array:
    a = np.abs(x)
    return a + np.log1p(np.exp(-2.0 * a)) - np.log(2.0)
