"""Friction that builds up over a way: surfaces bend before they slip."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, nogil=True)
def bristle(q, level, way):
    """(N,) friction that follows ±level over the way that is travelled, dF/ds = (±level - F)/way
    with s the path and the sign of the motion: Dahl's law, and LuGre's in slow motion. Exact
    between samples of the displacement q (N,), over which level and way (N,) are their means."""
    out = np.empty(len(q))
    force = 0.0
    for k in range(len(q)):
        step = q[k] - q[k - 1] if k > 0 else 0.0
        if step != 0.0:
            to = 0.5 * (level[k] + level[k - 1]) * np.sign(step)
            force = to + (force - to) * np.exp(-2.0 * abs(step) / (way[k] + way[k - 1]))
        out[k] = force
    return out


def brushed(q, dq, level, way, lag):
    """(N,) the same of bristles that are damped as they bend: F + lag·dF/dt, LuGre's σ0·z + σ1·ż
    with lag = σ1/σ0 in s. q, dq, level, way (N,) of the joint."""
    force = bristle(q, level, way)
    if lag == 0.0:
        return force
    return force + lag * (level * dq - force * np.abs(dq)) / way
