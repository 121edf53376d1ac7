"""One joint's judged error samples of all runs in a row, and bins of any quantity over them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from pa10d.compare.quantities import Quantity, Values
from pa10d.judgement.residuals import RunResidual
from pa10d.judgement.scores import moving

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

BINS = 24


@dataclass(frozen=True)
class JointSamples:
    """parts: per run the error (M,) N·m and where it counts; x (K,) per quantity."""

    joint: int
    parts: list[tuple[Array, Mask]]
    x: dict[Quantity, Array]
    rate: float

    @property
    def error(self) -> Array:
        """(K,) N·m."""
        return np.concatenate([error[mask] for error, mask in self.parts])


def joint_samples(
    runs: list[RunResidual],
    joint: int,
    looked_at: list[Quantity],
    of_run: dict[RunResidual, Values],
    judged: bool = False,
) -> JointSamples:
    """Runs in which the joint rests are left out where there are others. judged: clear of
    reversals, as errors are judged."""
    used = moving(runs, joint)
    masks = [(run.judged if judged else run.counts)[:, joint] for run in used]
    x = {
        quantity: np.concatenate([of_run[r](quantity)[m] for r, m in zip(used, masks, strict=True)])
        for quantity in looked_at
    }
    parts = [(run.error[:, joint], mask) for run, mask in zip(used, masks, strict=True)]
    return JointSamples(joint, parts, x, used[0].equation.rate)


@dataclass(frozen=True)
class Bins:
    """edges (B+1,); member (B, K) sparse, 1 where a sample lies in a bin; count (B,)."""

    quantity: Quantity
    edges: Array
    member: scipy.sparse.csr_array
    count: Array

    def sums(self, values: Array) -> Array:
        """(K,) or (K, S) -> per bin, (B,) or (B, S)."""
        return np.asarray(self.member @ values)


def bins(quantity: Quantity, x: Array, use: Mask) -> Bins | None:
    """Bins with equally many of the used samples each; None where the quantity hardly varies."""
    at = np.flatnonzero(use & np.isfinite(x))
    if len(at) < 4 * BINS:
        return None
    edges = np.unique(np.quantile(x[at], np.linspace(0, 1, BINS + 1)))
    visited = np.unique(np.searchsorted(edges[1:-1], x[at], side="right"))
    # a quantity that takes few values has quantiles between them, and nothing there
    edges = np.append(edges[visited], edges[-1])
    number = len(visited)
    if number < 4:
        return None
    index = np.searchsorted(edges[1:-1], x[at], side="right")
    ones = np.ones(len(at))
    member = scipy.sparse.csr_array((ones, (index, at)), shape=(number, len(x)))
    return Bins(quantity, edges, member, np.bincount(index, minlength=number).astype(float))
