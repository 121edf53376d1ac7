"""Where a joint's friction is over with turning round.

Just after a reversal friction may be anything: it sticks, creeps, and builds up over a way. What it
does there would tell a delay that is none, or a sign; moving masses do not lie.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SLOW = 0.03  # of the fast speed
FAR = 0.05  # of a joint's range


def steady_direction(q: Array, dq: Array, fast: Array, far: float = FAR) -> Array:
    """(N, n) the direction of joints that are fast and far from where they last turned, else 0.

    q rad and dq rad/s (N, n); fast (n,) rad/s: what counts as fast; far: part of a joint's range.
    Where a low-pass of it stays above 0.99 in size, nothing turned round within its memory.
    """
    away = way_since_turning(q, dq) >= far * np.ptp(q, axis=0)
    return np.where(away & (np.abs(dq) > SLOW * fast), np.sign(dq), 0.0)


def way_since_turning(q: Array, dq: Array) -> Array:
    """(N, n) rad from where each joint last turned round (from the first sample before that)."""
    turns = np.zeros(q.shape, dtype=bool)
    turns[1:] = np.sign(dq[1:]) != np.sign(dq[:-1])
    last = np.maximum.accumulate(np.where(turns, np.arange(len(q))[:, None], 0), axis=0)
    return np.asarray(np.abs(q - np.take_along_axis(q, last, axis=0)))
