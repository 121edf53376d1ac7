"""Covariance of scores under errors that are correlated in time and between joints.

Estimates move with scores, Σ_t x_t·e_t. The residual e is neither white (filter, controller,
unmodelled torque) nor equally strong in every pose. Two estimates of the scores' covariance
Σ_t Σ_s x_t·E[e_t e_s]·x_sᵀ stand beside each other: one takes each joint's residual as stationary
with the autocovariance it shows (sharp, but blind to errors that grow in certain poses or that
joints share), one sums scores over blocks of time (robust, but rough). The first gives the
covariance; where the second is larger by more than its own roughness, standard errors are raised
to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.regression.spectrum import (
    autocovariance,
    coloured_gram,
    correlation_length,
    flat_top,
    longest_lag,
)

Array = NDArray[np.float64]

BLOCK = 1.0  # s, shortest block of scores
FEWEST_BLOCKS = 24


@dataclass(frozen=True)
class Memory:
    """How a joint's residual remembers itself: its autocovariance (L+1,), tapered, and the seconds
    over which it is correlated."""

    gamma: Array
    seconds: float

    @classmethod
    def of(
        cls, parts: Sequence[tuple[Array, NDArray[np.bool_]]], rate: float, leverage: float = 0.0
    ) -> Memory:
        """Of a residual in stretches (values, mask); ``leverage``: unknowns that its equation had
        to pay for, each of which took one independent value's worth of it away."""
        gamma, count = autocovariance(parts, longest_lag([len(k) for _, k in parts], rate))
        reach = correlation_length(gamma, count)
        independent = max(count / _alike(gamma, reach), 2.0)
        paid = independent / max(independent - leverage, 0.5 * independent)
        return cls(flat_top(gamma, reach)[: 2 * reach + 1] * paid, reach / rate)


def block_of(memories: Sequence[Memory], samples: int, rate: float) -> int:
    """Samples of a block of scores: twice the longest memory, as far as enough blocks remain."""
    longest = max(m.seconds for m in memories)
    return max(1, min(int(max(BLOCK, 2.0 * longest) * rate), samples // FEWEST_BLOCKS))


class ScoreVectors:
    """Those of one joint, taken in a stretch after the other; all in weighted units.

    gram (k, k): their covariance if the residual is stationary; blocks (B, k): their sums over
    blocks of time, none where no residual was given.
    """

    def __init__(self, memory: Memory, block: int = 0) -> None:
        self._memory, self._block = memory, block
        self._sums: list[Array] = []
        self.gram: Array = np.zeros(())

    def add(self, columns: Array, residual: Array | None = None) -> None:
        """columns (M, k), zero where nothing counts; residual (M,)."""
        self.gram = self.gram + coloured_gram(columns, self._memory.gamma)
        if residual is not None:
            starts = np.arange(0, len(residual), self._block)
            self._sums.append(np.add.reduceat(columns * residual[:, None], starts, axis=0))

    @property
    def blocks(self) -> Array | None:
        """Of all stretches."""
        return np.concatenate(self._sums) if self._sums else None


def covariance_of(scores: Sequence[ScoreVectors], turns: Sequence[Array]) -> tuple[Array, Array]:
    """(p, p) covariance of Σ_j turn_j · scores_j, with turn_j (p, k_j), and (p,) the factors by
    which blocks of time raised the standard errors."""
    smooth = np.sum([t @ s.gram @ t.T for s, t in zip(scores, turns, strict=True)], axis=0)
    inflation = np.ones(len(smooth))
    sums = [s.blocks for s in scores]
    moves = [b @ t.T for b, t in zip(sums, turns, strict=True) if b is not None]
    if len(moves) < len(sums):
        return smooth, inflation
    moved = np.sum(moves, axis=0)
    count = len(moved)
    rough = np.sum(moved**2, axis=0) * count / max(count - 1, 1)
    none = np.diag(smooth) <= 0.0  # a flat-top window may leave less than none of a variance
    smooth[none, :], smooth[:, none] = 0.0, 0.0
    smooth[none, none] = rough[none]
    ratio = np.sqrt(rough / np.maximum(np.diag(smooth), 1e-300))
    inflation = np.where(ratio > 1.0 + 2.0 / np.sqrt(2.0 * count), ratio, 1.0)
    return smooth * np.outer(inflation, inflation), inflation


def _alike(gamma: Array, reach: int) -> float:
    """Samples that together are worth one independent one, for judging the variance."""
    if gamma[0] <= 0:
        return 1.0
    rho = flat_top(gamma, reach)[1:] / gamma[0]
    return 1.0 + 2.0 * float(np.sum(rho**2))
