"""How uncertain estimates are, as models and findings state it: one way for all who fit.

Noise (see ``scores``), what the model itself lacks (``lacking``) and has absorbed of it
(``suspects``), and what was known before the data.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.measurement.signals import Lowpass
from pa10d.regression.lacking import Stretch, lacking, weight_of
from pa10d.regression.scores import Memory, ScoreVectors, block_of, covariance_of
from pa10d.regression.suspects import Suspects, Tally, worst

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Uncertainty:
    """covariance (p, p) of the estimates; correlation (n,) s, over which residuals are correlated;
    inflation (p,) factors by which blocks of time raised the standard errors."""

    covariance: Array
    correlation: Array
    inflation: Array

    def first(self, size: int) -> Uncertainty:
        """The same for the first ``size`` estimates."""
        return Uncertainty(self.covariance[:size, :size], self.correlation, self.inflation[:size])


@dataclass(frozen=True)
class WeightedStretch:
    """A stretch of one joint's equation. columns (M, k): weighted, zero where nothing counts; the
    estimates answer to their products with errors. basis: gives (m, r) rows of the orthonormal
    basis of the whole weighted fit, where something counts."""

    columns: Array
    basis: Callable[[], Array]


def uncertainty(
    stretches: Sequence[Stretch],
    seen: Callable[[], Iterator[Sequence[WeightedStretch]]],
    turns: Sequence[Array],
    sigma: Array,
    leverage: Array,
    lowpass: Lowpass,
    known: Array | None = None,
) -> Uncertainty:
    """Of estimates that errors e_j (weighted) move by Σ_j turn_j · columns_jᵀ · e_j.

    stretches: what the fit leaves, and the motion behind it; seen: yields every joint's part of
    one stretch after the other; turns[j] (p, k_j)
    sigma, leverage: (n,) N·m the joints' weights are 1/σ²; unknowns that each had to pay for
    known: (p, p) covariance that is not of these data, but of what was known before
    """
    rate = lowpass.rate / lowpass.factor
    joints = range(len(sigma))
    whitened = [s.residual / sigma for s in stretches]
    memories = [
        Memory.of(
            [(r[:, j], s.keep[:, j]) for r, s in zip(whitened, stretches, strict=True)],
            rate,
            float(leverage[j]),
        )
        for j in joints
    ]
    block = block_of(memories, sum(len(r) for r in whitened), rate)
    scores = [ScoreVectors(memory, block) for memory in memories]
    lack = lacking(stretches, lowpass) / sigma**2
    suspects = Suspects(stretches)
    tallies = {j: Tally() for j in joints if lack[j] > 0.0}
    grams = {j: np.zeros((turns[j].shape[1],) * 2) for j in tallies}
    for stretch, residual, parts in zip(stretches, whitened, seen(), strict=True):
        for j, part in enumerate(parts):
            scores[j].add(part.columns, residual[:, j])
            if j in tallies:
                keep = stretch.keep[:, j]
                own = part.columns[keep]
                grams[j] += own.T @ own
                families = suspects.families(stretch, j)
                tallies[j].add(families, part.basis(), residual[keep, j], own)
    whole, inflation = covariance_of(scores, turns)
    if known is not None:
        whole = whole + known
    weight = weight_of(lack, np.sum([s.keep.sum(axis=0) for s in stretches], axis=0))
    for j, tally in tallies.items():
        moved = [weight[j] * grams[j], *tally.doubts(float(lack[j]))]
        whole = whole + worst([turns[j] @ doubt @ turns[j].T for doubt in moved])
    return Uncertainty(whole, np.array([m.seconds for m in memories]), inflation)
