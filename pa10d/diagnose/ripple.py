"""Where to start looking for torque ripple: the spectrum of the residual against angle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.side import PerJoint, Side

Array = NDArray[np.float64]

HIGHEST_ORDER = 220.0  # cycles per revolution
LOWEST_ORDER = 4.0  # below, gravity and ripple cannot be told apart


def order_peaks(side: Side, residual: PerJoint, joint: int, count: int = 3) -> list[float]:
    """Orders N (cycles per revolution) of the strongest lines of the residual against q_j.

    The power of residual·exp(-iNq), each sample weighted with what the low-pass leaves of a line
    at its momentary frequency N·|q̇|/2π, over a grid as fine as the range of q resolves.
    """
    spread = [run.context.q[:: run.lowpass.factor, joint] for run in side.runs]
    speeds = [run.context.dq[:: run.lowpass.factor, joint] for run in side.runs]
    keep = [k[:, joint] for k in side.keep]
    q = np.concatenate([x[k] for x, k in zip(spread, keep, strict=True)])
    v = np.abs(np.concatenate([x[k] for x, k in zip(speeds, keep, strict=True)]))
    r = residual[joint]
    span = float(q.max() - q.min())
    if span < 1e-3:
        return []
    step = max(0.12, np.pi / span / 3.0)
    orders = np.arange(LOWEST_ORDER, HIGHEST_ORDER, step)
    lowpass = side.runs[0].lowpass
    score = np.empty(len(orders))
    order_of_filter = 2 * lowpass.order
    for start in range(0, len(orders), 64):
        some = orders[start : start + 64, None]
        gain = 1.0 / (1.0 + (some * v / (2 * np.pi * lowpass.cutoff)) ** order_of_filter)
        line = gain * np.exp(-1j * some * q)
        power = np.sum(gain**2, axis=1)
        score[start : start + 64] = np.abs(line @ r) ** 2 / np.maximum(power, 1e-12)
    peaks = np.flatnonzero((score[1:-1] >= score[:-2]) & (score[1:-1] >= score[2:])) + 1
    best = peaks[np.argsort(score[peaks])[::-1][:count]]
    return [float(orders[i]) for i in best]
