"""Where something holds without a break."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def spans(flags: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(k, 2) first index and the one after the last, wherever ``flags`` (N,) are True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return edges.reshape(-1, 2)
