"""Errors that follow a fixed curve against a quantity, spread over its whole range.

Such an error (a missing offset, a wrong slope) piles up nowhere, so no region shows it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.compare.correlation import autocorrelation
from pa10d.compare.quantities import Quantity
from pa10d.compare.samples import Bins, JointSamples

Array = NDArray[np.float64]

LONGEST_MEMORY = 10.0  # s: correlation that is looked for
BATCH = 4.0  # memories of the error: the means of stretches so long are nearly independent
FEWEST_BATCHES = 4
HALVED = 2.0  # memories that are worth one independent value of a mean, where stretches are too few


@dataclass(frozen=True)
class Curve:
    """quantity: None for a constant; low, high: range visited; level: N·m, of the constant
    share: of the joint's squared error"""

    quantity: Quantity | None
    low: float
    high: float
    share: float
    level: float = 0.0

    @property
    def excess(self) -> float:
        """To be ranked beside regions."""
        return self.share


def follows(table: Bins, error: Array, square: Array) -> Array:
    """Share of squared error ``square`` (S,) that the mean per bin takes; error (B, S): Σe."""
    return np.asarray((error**2 / table.count[:, None]).sum(axis=0) / np.maximum(square, 1e-300))


def curve_values(table: Bins, error: Array) -> Array:
    """(K,) the mean of its bin at every sample, 0 where the quantity has no value; error (K,)."""
    return np.asarray(table.member.T @ (table.sums(error) / table.count))


def find_constant(samples: JointSamples, q: Array) -> tuple[Curve, float]:
    """The mean error as a curve over the positions q (K,), and its two-sided p, by Student's test
    on the means of stretches that are long against the error's memory."""
    error = samples.error
    memory = autocorrelation(samples.parts, lags=int(LONGEST_MEMORY * samples.rate) + 2)
    length = max(1, int(BATCH * memory.time))
    means = np.array(
        [
            part.mean()
            for values in (error[mask] for error, mask in samples.parts)
            for part in np.array_split(values, max(1, len(values) // length))
            if len(part)
        ]
    )
    level = float(error.mean())
    share = level**2 / max(float(np.mean(error**2)), 1e-300)
    curve = Curve(None, float(q.min()), float(q.max()), share, level)
    if len(means) >= FEWEST_BATCHES:
        count, middle, std = float(len(means)), float(means.mean()), float(means.std(ddof=1))
    else:  # a few long memories in all: each counts as half a stretch
        count, middle, std = len(error) / (HALVED * memory.time), level, float(error.std())
    if count < 2.0:
        return curve, 1.0
    spread = max(std, 1e-300) / np.sqrt(count)
    return curve, float(2 * scipy.stats.t.sf(abs(middle) / spread, count - 1))
