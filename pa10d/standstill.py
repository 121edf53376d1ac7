"""Where joints stand still: friction is indeterminate there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.signals import Lowpass

Array = NDArray[np.float64]

STILL_SHARE = 0.01  # of the 99 % quantile of speed: slower is standing or creeping
RESTING = 0.08  # s: a stop that long is a rest, a shorter one a reversal
REACH = 0.8  # periods of the cut-off over which the filter remembers a standstill


def fast_speed(dq: Array) -> Array:
    """(n,) rad/s: the 99 % quantile of each joint's speed."""
    return np.asarray(np.quantile(np.abs(dq), 0.99, axis=0))


def standstill(
    dq: Array,
    rate: float,
    lowpass: Lowpass,
    fast: Array | None = None,
    longer_than: float = 0.0,
    reach: float = REACH,
) -> NDArray[np.bool_]:
    """(M, n): True where joint i stands, or stood so near that the filter still sees it.

    A joint stands while its speed is below STILL_SHARE of its fast speed. Creeping counts, and so
    does the instant of a reversal: a real joint sticks there, for how long nobody measured, and
    friction is anything between ±Fs meanwhile. ``longer_than`` s leaves out shorter stops;
    ``reach``: periods of the cut-off.
    """
    samples, n = dq.shape
    samples_near = int(reach / lowpass.cutoff * rate)
    shortest = max(1, int(longer_than * rate))
    out = np.zeros((lowpass.kept, n), dtype=bool)
    limits = np.maximum(STILL_SHARE * (fast_speed(dq) if fast is None else fast), 1e-9)
    for j, limit in enumerate(limits):
        slow = np.abs(dq[:, j]) < limit
        slow[1:] |= np.diff(np.sign(dq[:, j])) != 0
        edges = np.flatnonzero(np.diff(np.concatenate([[0], slow.astype(np.int8), [0]])))
        near = np.zeros(samples + 1)
        for start, stop in edges.reshape(-1, 2):
            if stop - start >= shortest:
                near[max(0, start - samples_near)] += 1
                near[min(samples, stop + samples_near)] -= 1
        out[:, j] = np.cumsum(near)[: samples : lowpass.factor] > 0
    return out
