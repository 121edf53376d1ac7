"""Did a joint become worse? Two models of one arm on the same samples of the same runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.judgement.residuals import RunResidual, hidden_in
from pa10d.judgement.scores import moving

Array = NDArray[np.float64]

BLOCK_SECONDS = 1.0  # longer than what the torque's noise remembers of itself
SURE = 3.0  # standard errors
MATERIAL = 1.05  # times the error before: less is not worth a word
FEWEST = 4  # blocks


def worse(before: Sequence[RunResidual], after: Sequence[RunResidual]) -> list[int]:
    """Joints (0-based) whose error rose significantly and materially.

    before, after: the same runs through either model; the rise of squared error is averaged over
    blocks of time, whose scatter says how sure it is. Runs count in which the joint moves, as in
    the error that is shown. A joint whose torque is known nowhere is not asked.
    """
    asked = {*range(before[0].error.shape[1])} - {*hidden_in(before)}
    return [j for j in sorted(asked) if _rose(before, after, j)]


def _rose(before: Sequence[RunResidual], after: Sequence[RunResidual], joint: int) -> bool:
    old, new, weight = [], [], []
    counted = moving(before, joint), moving(after, joint)
    for first, second in zip(*counted, strict=True):
        counts = first.judged[:, joint] & second.judged[:, joint]
        length = max(1, round(BLOCK_SECONDS * first.equation.rate))
        starts = np.arange(0, len(counts), length)
        old.append(np.add.reduceat(np.where(counts, first.error[:, joint] ** 2, 0.0), starts))
        new.append(np.add.reduceat(np.where(counts, second.error[:, joint] ** 2, 0.0), starts))
        weight.append(np.add.reduceat(counts.astype(float), starts))
    was, now, count = (np.concatenate(x) for x in (old, new, weight))
    used = count > 0
    if used.sum() < FEWEST or now.sum() <= MATERIAL**2 * was.sum():
        return False
    rise = now[used] - was[used]
    scatter = float(np.sqrt(np.sum((rise - rise.mean()) ** 2)))
    return bool(rise.sum() > SURE * scatter)
