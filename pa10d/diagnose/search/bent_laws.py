"""Laws that would hold, were they still themselves: at the end of its range one is another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.diagnose.constants import CLAIMED_SHARE
from pa10d.diagnose.search.judging import JudgedCandidate
from pa10d.diagnose.unknown.remaining import Unnamed


def bent_laws(judged: Sequence[JudgedCandidate]) -> list[Unnamed]:
    """Of each joint the one that takes most of its error, by the quantity that it is drawn over."""
    best: dict[int, Unnamed] = {}
    for one in judged:
        kind, joints = one.candidate.effect, one.candidate.joints
        if len(joints) != 1 or kind.drawn.against not in ("q", "dq"):
            continue
        (j,) = joints
        before, after = float(one.evidence.before[j]), float(one.evidence.after[j])
        share = 1.0 - (after / max(before, 1e-300)) ** 2
        if share > max(CLAIMED_SHARE, best[j].share if j in best else 0.0):
            size = float(np.sqrt(share) * before)
            variables = (f"{kind.drawn.against}{j + 1}",)
            best[j] = Unnamed(j, share, size, one.p_corrected, "law", variables)
    return list(best.values())
