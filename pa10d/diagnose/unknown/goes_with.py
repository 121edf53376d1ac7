"""A joint whose rest goes with what remains on another one: the reaction of what is missing there.

Play behind joint 2 throws link 2 about, and joint 1 feels that through the bodies, whichever way it
moves itself: no quantity of the motion says it, but the other joint's rest does. How they go
together is settled on the fit side, over one period of the cut-off to either side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import BROKEN_SHARE, CLUSTERS, FORETOLD_LEVEL, SLOPES
from pa10d.diagnose.evidence.held_out import judge
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.regression.equation import OVERSAMPLING
from pa10d.regression.per_joint import PerJoint, rms

Array = NDArray[np.float64]
AROUND = int(OVERSAMPLING)  # samples to either side: one period of the cut-off


@dataclass(frozen=True)
class GoesWith:
    """share of a joint's held-out squared error that another one's rest (0-based) foretells."""

    other: int
    share: float


def goes_with(
    state: SearchState, joints: Sequence[int], others: Sequence[int]
) -> dict[int, GoesWith]:
    """By joint, of these: which of the others its rest goes with most, where that is most of it."""
    found: dict[int, GoesWith] = {}
    train, held = state.train_residual(), state.held_residual()
    for j in joints:
        for k in others:
            if k == j or not len(held[j]) or not len(held[k]):
                continue
            share = _share(state, train, held, j, k, len(joints) * len(others))
            if share > max(BROKEN_SHARE, found[j].share if j in found else 0.0):
                found[j] = GoesWith(k, share)
    return found


def _share(
    state: SearchState, train: PerJoint, held: PerJoint, j: int, k: int, tried: int
) -> float:
    """Zero where it may be chance."""
    columns = _around(state.train, train, j, k)
    weights = np.linalg.lstsq(columns, train[j], rcond=1e-6)[0]
    change = _around(state.held, held, j, k) @ weights
    evidence = judge(state.held, held, {j: change})
    sure = evidence.p_value * tried < FORETOLD_LEVEL and evidence.cluster_t > CLUSTERS
    if not (sure and SLOPES[0] < evidence.slope < SLOPES[1]):
        return 0.0
    return float(1.0 - (rms(held[j] - change) / rms(held[j])) ** 2)


def _around(side: Side, residual: PerJoint, j: int, k: int) -> Array:
    """(m_j, 2·AROUND + 1) N·m: what is left of joint k around the samples of joint j's equation."""
    rows = []
    for left in side.scatter({k: residual[k]}):
        wide = np.pad(left[:, k], AROUND)
        rows.append(np.lib.stride_tricks.sliding_window_view(wide, 2 * AROUND + 1))
    return side.gathered(rows, j)
