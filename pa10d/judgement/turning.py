"""Is an error larger just after a joint has turned round? Noise does not know when that was.

Of every stroke between two reversals the first moments are set against as many in its middle, both
clear of the reversals themselves. If the error were noise that goes on alike, whatever its colour,
either could as well be the larger one: Wilcoxon's signed ranks of the strokes.

What the low-pass would carry there from the standstill itself is no part of the judged error
(``pa10d/regression/rests.py``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.judgement.residuals import RunResidual
from pa10d.measurement.spans import spans

Array = NDArray[np.float64]

FEWEST = 12  # strokes below which nothing is said: 2⁻¹² is as unlikely as such a word may be
PARTS = 3  # windows that a stroke must be long: its beginning, its middle and room between them


@dataclass(frozen=True)
class Turning:
    """Of one joint. p_value: one-sided, that noise is that much larger after reversals; share: of
    the squared error, that the middles of the strokes do not have; larger, strokes: in how many
    of them the beginning is the worse part."""

    p_value: float
    share: float
    larger: int
    strokes: int


def turning(runs: Sequence[RunResidual]) -> list[Turning | None]:
    """Per joint; None where it has turned round too seldom."""
    return [_of_joint(runs, j) for j in range(runs[0].error.shape[1])]


def _of_joint(runs: Sequence[RunResidual], joint: int) -> Turning | None:
    pairs = np.array([pair for run in runs for pair in _strokes(run, joint)])
    if len(pairs) < FEWEST:
        return None
    early, middle = pairs.T
    counted = np.concatenate([run.error[run.judged[:, joint], joint] for run in runs])
    share = 1.0 - float(middle.mean()) / max(float(np.mean(counted**2)), 1e-300)
    ratio = np.log(np.maximum(early, 1e-300) / np.maximum(middle, 1e-300))
    p = float(scipy.stats.wilcoxon(ratio, alternative="greater").pvalue)
    return Turning(p, max(share, 0.0), int(np.sum(ratio > 0)), len(pairs))


def _strokes(run: RunResidual, joint: int) -> Iterator[tuple[float, float]]:
    """Mean squares (N·m)² of the beginning and of the middle of each stroke."""
    judged, moves = run.judged[:, joint], run.counts[:, joint]
    error = run.error[:, joint]
    width = int(np.ceil(run.equation.rate / run.equation.lowpass.cutoff))
    for start, stop in spans(judged):
        turned = start > 0 and moves[start - 1]  # and not: the run began, or it had rested
        if turned and stop - start >= PARTS * width:
            at = (start + stop - width) // 2
            yield (
                float(np.mean(error[start : start + width] ** 2)),
                float(np.mean(error[at : at + width] ** 2)),
            )
