"""How much of a joint's error lies in the knocks of a gap, whose moments nobody foretells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pa10d.diagnose.regression.clear_of_knocks import blurred, clear_samples
from pa10d.diagnose.regression.state import SearchState


@dataclass(frozen=True)
class AmongKnocks:
    """of: joints (0-based) that have a gap; share: of a joint's squared error, in so large a part
    of its samples; rest: N·m RMS that the joint keeps in the others."""

    of: tuple[int, ...]
    share: float
    part: float
    rest: float


def among_knocks(state: SearchState) -> dict[int, AmongKnocks]:
    """By joint (0-based) that knocks reach, held out."""
    clear = clear_samples(state)
    if clear is None:
        return {}
    gaps = [t.joints for index, t in enumerate(state.terms) if blurred(state, index)]
    of = tuple(sorted({j for joints in gaps for j in joints}))
    within = state.held.rows_within(state.held.where(clear[1]))
    out = {}
    for joint, left in state.held_residual().items():
        elsewhere = left[within[joint]]
        if len(elsewhere) == len(left) or not len(elsewhere):
            continue
        share = 1.0 - float(elsewhere @ elsewhere) / max(float(left @ left), 1e-300)
        part = 1.0 - len(elsewhere) / len(left)
        out[joint] = AmongKnocks(of, share, part, float(np.sqrt(np.mean(elsewhere**2))))
    return out
