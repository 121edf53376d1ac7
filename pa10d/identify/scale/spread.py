"""Whether recordings agree about a gain, and what it adds to the error where they do not.

Each loaded run has a gain of its own, with an error from what *its* gain leaves unexplained: what
the common gain leaves holds the disagreement already. The part of the runs' spread that these
errors do not explain is taken for a spread of the gain itself. Where the runs are equally good and
know nothing of each other, that is the scale factor of the Particle Data Group's averages.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from pa10d.identify.scale.rows import SEEN, WeighingEquations, sums_over_blocks, without

Array = NDArray[np.float64]

DISAGREE = 0.05  # chance at which recordings of one joint are said to disagree
ALIKE = 1e-6  # of a gain: runs that are no further apart are the same


@dataclass(frozen=True)
class RunByRun:
    """gains (R,): one of each loaded run; noise (R, R): their covariance; weights (R, R): what the
    weights' errors make of the gains, at a gain of 1; loaded (M, R): what they are gains of; left
    (M,): what they do not explain."""

    gains: Array
    noise: Array
    weights: Array
    loaded: Array
    left: Array

    def error_of(self, gain: float, share: Array) -> tuple[float, bool, float]:
        """Standard error of the common gain by noise and disagreement; whether they disagree by
        more than chance, and then the gain's standard deviation from run to run. share (R,): what
        each run's gain is of the common one; sums to 1."""
        apart = self.noise + gain**2 * self.weights
        counts = np.abs(share) / np.abs(share).sum()
        away = np.eye(len(share)) - share  # times the gains: how far each lies from the common one
        spread, explained, of_one = (
            float(counts @ squares)
            for squares in (
                (away @ self.gains) ** 2, np.diag(away @ apart @ away.T), np.diag(away @ away.T)
            )
        )  # fmt: skip
        beyond = max(spread - explained, 0.0) / of_one  # variance of the gain from run to run
        variance = share @ self.noise @ share + beyond * (share @ share)
        disagree = self._chance(gain, apart) < DISAGREE
        return float(np.sqrt(variance)), disagree, float(np.sqrt(beyond)) if disagree else 0.0

    def _chance(self, gain: float, covariance: Array) -> float:
        """That runs of one gain lie as far apart."""
        free = len(self.gains) - 1
        contrast = np.hstack([-np.ones((free, 1)), np.eye(free)])
        apart = contrast @ self.gains
        size = contrast @ covariance @ contrast.T + (ALIKE * gain) ** 2 * np.eye(free)
        return float(chdtrc(free, apart @ np.linalg.solve(size, apart)))


def run_by_run(rows: WeighingEquations, basis: Array) -> RunByRun | None:
    """None where there are no two gains to tell apart."""
    numbers = np.unique(rows.runs[rows.load >= 0])
    loaded = np.column_stack([np.where(rows.runs == k, rows.asked, 0.0) for k in numbers])
    x = without(loaded, basis)
    u, s, vt = np.linalg.svd(x, full_matrices=False)
    if len(numbers) < 2 or s[-1] <= np.sqrt(SEEN) * s[0]:
        return None
    inverse = (vt.T / s) @ u.T
    gains = inverse @ rows.torque
    left = without(rows.torque, basis) - x @ gains
    sums = np.stack([sums_over_blocks(row * left, rows.blocks) for row in inverse])
    return RunByRun(gains, sums @ sums.T, _by_weights(rows, inverse), loaded, left)


def _by_weights(rows: WeighingEquations, inverse: Array) -> Array:
    """(R, R): a weight is off alike in all its runs, each weight by itself."""
    out = np.zeros((len(inverse), len(inverse)))
    for load in np.unique(rows.load[rows.load >= 0]):
        here = rows.load == load
        moved = inverse[:, here] @ rows.doubt[here]
        out += moved @ moved.T
    return out
