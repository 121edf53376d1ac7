"""Laws that would hold, were they still themselves: at the end of its range one is another; or did
the runs held out go where they act."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np

from pa10d.common.words import listed
from pa10d.diagnose.constants import CLAIMED_SHARE
from pa10d.diagnose.search.judging import JudgedCandidate
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.effects import Effect, Shape

QUANTITIES = {"q": "q", "dq": "dq", "travel": "q"}
"""What an effect is drawn over -> what its error depends on; travel: an angle since it turned."""


def bent_laws(judged: Iterable[JudgedCandidate]) -> list[Unnamed]:
    """Of each joint the one that takes most of its error, by the quantity that it is drawn over."""
    best: dict[int, Unnamed] = {}
    for one in judged:
        kind, joints = one.candidate.effect, one.candidate.joints
        if len(joints) != 1 or kind.drawn.against not in QUANTITIES:
            continue
        (j,) = joints
        before, after = float(one.evidence.before[j]), float(one.evidence.after[j])
        share = 1.0 - (after / max(before, 1e-300)) ** 2
        if share > max(CLAIMED_SHARE, best[j].share if j in best else 0.0):
            size = float(np.sqrt(share) * before)
            variables = (f"{QUANTITIES[kind.drawn.against]}{j + 1}",)
            ends = "" if one.unseen else f" with {_ends(kind, one.candidate.shape)}"
            witness: Literal["law", "unseen"] = "unseen" if one.unseen else "law"
            law = f"{kind.named}{ends}"
            best[j] = Unnamed(j, share, size, one.p_corrected, witness, variables, law=law)
    return list(best.values())


def _ends(kind: Effect, shape: Shape) -> str:
    """``zs = 0.2 rad``: of what is at the end of its range."""
    ends = [s for s in kind.shapes_in(shape) if s.at_edge(shape[s.name])]
    return listed([f"{s.name} = {shape[s.name]:.3g} {s.unit}".rstrip() for s in ends])
