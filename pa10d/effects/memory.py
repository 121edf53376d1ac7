"""What fades: the recursion of everything that remembers with one time constant."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, nogil=True)
def fading(added, kept):
    """(N,) y[k] = kept·y[k-1] + added[k], from nothing."""
    out = np.empty(len(added))
    level = 0.0
    for k in range(len(added)):
        level = kept * level + added[k]
        out[k] = level
    return out
