"""Where what two joints share sticks, though each of them moves: for how long nobody knows.

A joint's own reversals are left out of what is judged. Those of a speed that two joints have
together are not: the law that they share is looked for in all of its samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from pa10d.judgement import RunResidual
from pa10d.model import Term, TorqueModel
from pa10d.regression.rests import going

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class StuckTogether:
    """other: joint (0-based) that shares it; share: of a joint's squared error, where it sticks;
    rest: N·m RMS that the joint keeps elsewhere."""

    other: int
    share: float
    rest: float


def stuck_together(model: TorqueModel, seen: Sequence[RunResidual]) -> dict[int, StuckTogether]:
    """By joint (0-based), of the terms that two joints share; where several do, of that which takes
    most. seen: the held-out side as the model sees it."""
    found: dict[int, StuckTogether] = {}
    for term in model.terms:
        stood = [_stands(term, run) for run in seen]
        if any(one is None for one in stood):
            continue
        for joint, other in permutations(term.joints, 2):
            judged = [run.judged[:, joint] for run in seen]
            error = [run.error[one, joint] ** 2 for run, one in zip(seen, judged, strict=True)]
            there = [one[now] for one, now in zip(stood, judged, strict=True) if one is not None]
            own = _of(np.concatenate(error), np.concatenate(there), other)
            if own is not None and (joint not in found or own.share > found[joint].share):
                found[joint] = own
    return found


def _stands(term: Term, run: RunResidual) -> Mask | None:
    """(M,) where the surfaces of a term hardly slip, by the rule for a joint's own; None: it has no
    such surfaces."""
    speed = term.effect.slips(run.seen, term.joints, term.shape)
    if speed is None:
        return None
    return np.asarray(run.decimated(going(speed[:, None], run.equation.lowpass))[:, 0] < 1.0)


def _of(error: NDArray[np.float64], there: Mask, other: int) -> StuckTogether | None:
    if not there.any() or there.all() or not error.any():
        return None
    share = float(error[there].sum() / error.sum())
    return StuckTogether(other, share, float(np.sqrt(np.mean(error[~there]))))
