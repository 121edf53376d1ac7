"""Covariance of the estimates for errors that are correlated in time and between joints.

The residual is neither white (filter, controller, unmodelled torque) nor equally strong in every
pose. Two estimates of the scores' covariance Σ_t Σ_s x_t·E[e_t e_s]·x_sᵀ stand beside each other:
one takes each joint's residual as stationary with the autocovariance it shows (sharp, but blind
to errors that grow in certain poses or that joints share), one sums scores over blocks of time
(robust, but rough). The first gives the covariance; where the second is larger by more than its
own roughness, standard errors are raised to it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.rows import Rows
from pa10d.regression.lacking import Stretch, weight_of
from pa10d.regression.solution import Solution
from pa10d.regression.spectrum import autocovariance, coloured_gram, correlation_length, flat_top
from pa10d.regression.suspects import Suspects, Tally, worst

Array = NDArray[np.float64]

LONGEST = 2.0  # s over which a residual may be correlated at most
BLOCK = 1.0  # s, shortest block of scores
FEWEST_BLOCKS = 24


@dataclass(frozen=True)
class Uncertainty:
    """covariance (p, p) of the unknowns; correlation (n,) s, over which residuals are correlated;
    inflation (p,) factors by which blocks of time raised the standard errors."""

    covariance: Array
    correlation: Array
    inflation: Array

    def first(self, size: int) -> Uncertainty:
        """The same for the first ``size`` unknowns."""
        return Uncertainty(self.covariance[:size, :size], self.correlation, self.inflation[:size])


def covariance(
    stretches: Callable[[], Iterator[Rows]],
    indices: Sequence[NDArray[np.int64]],
    solution: Solution,
    residuals: Sequence[Array],
    keeps: Sequence[NDArray[np.bool_]],
    degrees: Array,
    rate: float,
    motion: Sequence[Stretch],
    lack: Array,
    known: Array | None = None,
) -> Uncertainty:
    """Sandwich covariance of a weighted solution.

    stretches: yields the rows again, in the order of ``residuals`` [(M, n) N·m] and ``keeps``
    degrees: (n,) unknowns that each joint's equation had to pay for; rate: decimated, Hz
    motion: of the same stretches; lack: (n,) (N·m)² of each residual that is the model's own (see
    ``lacking``)
    known: (p, p) of the normal matrix that was known before the data, with errors of its own
    """
    n, size = len(indices), len(solution.beta)
    longest = int(np.clip(LONGEST * rate, 4, max(4, max(len(r) for r in residuals) // 4)))
    tapered, length = [], np.zeros(n)
    for j in range(n):
        gamma, count = autocovariance(
            [(r[:, j], k[:, j]) for r, k in zip(residuals, keeps, strict=True)], longest
        )
        reach = correlation_length(gamma, count)
        independent = max(count / _spread(gamma, reach), 2.0)
        paid = independent / max(independent - degrees[j], 0.5 * independent)
        tapered.append(flat_top(gamma, reach)[: 2 * reach + 1] * paid / solution.sigma[j] ** 4)
        length[j] = reach / rate
    samples = sum(len(r) for r in residuals)
    own = weight_of(lack, np.sum([k.sum(axis=0) for k in keeps], axis=0)) / solution.sigma**4
    missing = np.zeros((n, size, size))
    suspects = Suspects(motion)
    tallies = {j: Tally() for j in range(n) if lack[j] > 0.0}
    block = max(1, min(int(max(BLOCK, 2 * length.max()) * rate), samples // FEWEST_BLOCKS))
    meat, blockwise, blocks = np.zeros((size, size)), np.zeros((size, size)), 0
    for rows, residual, moved in zip(stretches(), residuals, motion, strict=True):
        scores = np.zeros((-(-len(residual) // block), size))
        starts = np.arange(0, len(residual), block)
        for j, index in enumerate(indices):
            columns = np.where(rows.keep[:, j, None], rows.columns[j], 0.0)
            meat[np.ix_(index, index)] += coloured_gram(columns, tapered[j])
            missing[j][np.ix_(index, index)] += own[j] * (columns.T @ columns)
            if j in tallies:
                keep = rows.keep[:, j]
                basis = columns[keep] @ solution.right[index] / solution.sigma[j]
                tallies[j].add(suspects.families(moved, j), basis, residual[keep, j])
            weighted = columns * (residual[:, j, None] / solution.sigma[j] ** 2)
            scores[:, index] += np.add.reduceat(weighted, starts, axis=0)
        blockwise += scores.T @ scores
        blocks += len(scores)
    inverse = solution.right @ solution.right.T
    smooth = inverse @ meat @ inverse
    rough = np.diag(inverse @ blockwise @ inverse) * blocks / max(blocks - 1, 1)
    none = np.diag(smooth) <= 0.0  # a flat-top window may leave less than none of a variance
    smooth[none, :], smooth[:, none] = 0.0, 0.0
    smooth[none, none] = rough[none]
    ratio = np.sqrt(rough / np.maximum(np.diag(smooth), 1e-300))
    inflation = np.where(ratio > 1.0 + 2.0 / np.sqrt(2.0 * blocks), ratio, 1.0)
    whole = smooth * np.outer(inflation, inflation)
    if known is not None:
        whole = whole + inverse @ known @ inverse
    for j, tally in tallies.items():
        turn = solution.right / solution.sigma[j]
        named = [turn @ doubt @ turn.T for doubt in tally.doubts(float(lack[j]))]
        whole = whole + worst([inverse @ missing[j] @ inverse, *named])
    return Uncertainty(whole, length, inflation)


def _spread(gamma: Array, reach: int) -> float:
    """Samples that together are worth one independent one, for judging the variance."""
    if gamma[0] <= 0:
        return 1.0
    rho = flat_top(gamma, reach)[1:] / gamma[0]
    return 1.0 + 2.0 * float(np.sum(rho**2))
