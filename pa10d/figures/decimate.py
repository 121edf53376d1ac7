"""Long signals in as many points as a screen has, without losing a peak."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def extremes(signal: NDArray[Any], points: int) -> tuple[NDArray[Any], float]:
    """Smallest and largest value of each of ``points/2`` stretches, in the order in which they
    come, at equal distances. signal: (N,) or (N, k). Returns (P, …) and the distance of two
    points in samples; a signal that is short enough comes back as it is."""
    samples = len(signal)
    if samples <= points:
        return signal, 1.0
    width = -(-samples // (points // 2))
    pairs = -(-samples // width)
    missing = pairs * width - samples
    padded = np.concatenate([signal, np.repeat(signal[-1:], missing, axis=0)])
    stretches = padded.reshape(pairs, width, *signal.shape[1:])
    low, high = np.argmin(stretches, axis=1), np.argmax(stretches, axis=1)
    first, second = np.minimum(low, high), np.maximum(low, high)
    picked = np.stack([first, second], axis=1)
    out = np.take_along_axis(stretches, picked, axis=1)
    return np.asarray(out.reshape(2 * pairs, *signal.shape[1:])), width / 2


def peaks(x: Array, y: Array, points: int) -> tuple[Array, Array]:
    """Largest value of each stretch and where it is: for spectra, whose valleys say little."""
    samples = len(y)
    if samples <= points:
        return x, y
    width = -(-samples // points)
    whole = samples // width * width
    at = np.argmax(y[:whole].reshape(-1, width), axis=1) + np.arange(0, whole, width)
    if whole < samples:
        at = np.append(at, whole + int(np.argmax(y[whole:])))
    return x[at], y[at]


def thinned(count: int, most: int) -> NDArray[np.int64]:
    """Indices of at most ``most`` of ``count`` samples, spread evenly but not in step with
    anything periodic."""
    if count <= most:
        return np.arange(count)
    edges = np.linspace(0, count, most + 1)
    jitter = np.random.default_rng(0).random(most)
    return np.asarray(edges[:-1] + jitter * np.diff(edges)).astype(np.int64)
