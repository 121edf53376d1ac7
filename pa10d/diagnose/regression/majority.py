"""The model that most samples agree on: whose loads the candidates are computed from.

What is missing may act in knocks: a gap that is crossed, a stop that is hit. Least squares bends
the model towards them, and a load that is off by a small amount near its zero moves the very
moments at which a gap opens. A fit that such samples cannot drag along has the loads right
before anything is known about the knocks.

Beaton & Tukey, The fitting of power series, meaning polynomials, illustrated on band-spectroscopic
data, Technometrics 16 (1974); Huber & Ronchetti, Robust Statistics (2009).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import BIWEIGHT, HUBER, MAJORITY_ROUNDS, MAJORITY_THIN
from pa10d.diagnose.regression.least_squares import LeastSquares

Array = NDArray[np.float64]


def agreed(fit: LeastSquares) -> Array:
    """(p,) coefficients by iteratively reweighted least squares from this fit on."""
    residual = {j: r[::MAJORITY_THIN] for j, r in fit.residual.items() if len(r)}
    basis = {j: fit.basis[j][::MAJORITY_THIN] for j in residual}
    moved = np.zeros(len(fit.coordinates))
    # what the fit knew besides the data weighs as much as in the fit itself
    besides = np.eye(len(moved)) - np.sum([q.T @ q for q in fit.basis.values()], axis=0)
    pull = -np.sum([q.T @ fit.residual[j] for j, q in fit.basis.items()], axis=0)
    for number in range(sum(MAJORITY_ROUNDS)):
        gram, target = besides / MAJORITY_THIN, pull / MAJORITY_THIN
        for j, q in basis.items():
            left = residual[j] - q @ moved
            size = max(1.4826 * float(np.median(np.abs(left))), 1e-300)
            weight = _weights(np.abs(left) / size, redescending=number >= MAJORITY_ROUNDS[0])
            weighted = (weight / size**2)[:, None] * q
            gram += q.T @ weighted
            target += weighted.T @ residual[j]
        moved = np.asarray(np.linalg.lstsq(gram, target, rcond=1e-10)[0])
    return np.asarray(fit.beta + fit.to_beta @ moved)


def _weights(distance: Array, redescending: bool) -> Array:
    if redescending:
        return np.where(distance < BIWEIGHT, (1.0 - (distance / BIWEIGHT) ** 2) ** 2, 0.0)
    return HUBER / np.maximum(distance, HUBER)
