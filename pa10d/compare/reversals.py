"""When a joint last turned round, and how far it has come since."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NOISE_SHARE = 0.01  # of the joint's fast speed: a sign change must reach this to be a reversal


def reversal_samples(dq: Array) -> NDArray[np.int64]:
    """Indices at which the speed (N,) changes its sign for good, at its smallest size."""
    limit = NOISE_SHARE * float(np.quantile(np.abs(dq), 0.99))
    clear = np.flatnonzero(np.abs(dq) > limit)
    if limit <= 0 or len(clear) < 2:
        return np.empty(0, dtype=np.int64)
    turns = np.flatnonzero(np.diff(np.sign(dq[clear])) != 0)
    before, after = clear[turns], clear[turns + 1]
    return np.array(
        [b + int(np.argmin(np.abs(dq[b : a + 1]))) for b, a in zip(before, after, strict=True)],
        dtype=np.int64,
    )


def since_reversal(q: Array, dq: Array, dt: float) -> tuple[Array, Array]:
    """Time (N,) s and travel (N,) rad since the last reversal; nan before the first."""
    at = reversal_samples(dq)
    time, travel = np.full(len(q), np.nan), np.full(len(q), np.nan)
    if len(at) == 0:
        return time, travel
    last = np.searchsorted(at, np.arange(len(q)), side="right") - 1
    known = last >= 0
    start = at[last[known]]
    time[known] = (np.flatnonzero(known) - start) * dt
    travel[known] = np.abs(q[known] - q[start])
    return time, travel
