"""A fit that knocks, collisions and glitches do not drag along (Huber's weights)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.blocks import Pieces
from pa10d.identify.fit import Fit, weighted_fit
from pa10d.identify.rows import all_rows
from pa10d.identify.smoothing import Smoothing
from pa10d.regression.layout import Layout
from pa10d.regression.per_joint import gathered
from pa10d.regression.problem import LinearProblem

Array = NDArray[np.float64]

TUNING = 1.345  # standard deviations: 95 % efficient on clean data
ROUNDS = 15
SETTLED = 0.01  # standard errors


def robust_fit(pieces: Pieces, problem: LinearProblem[Layout], smoothing: Smoothing) -> Fit:
    """Iteratively reweighted least squares: samples whose residual exceeds TUNING robust standard
    deviations (from the median of absolute values) count in proportion to its inverse."""
    fit = weighted_fit(pieces, problem, smoothing)
    for _ in range(ROUNDS):
        before = fit.solution.beta
        weights = _weights(pieces, problem.unknowns, before)
        fit = weighted_fit(pieces, problem, smoothing, weights)
        errors = np.sqrt(np.maximum(np.diag(fit.uncertainty.covariance), 1e-300))
        if np.max(np.abs(fit.solution.beta - before) / errors) < SETTLED:
            break
    return fit


def _weights(pieces: Pieces, layout: Layout, beta: Array) -> list[Array]:
    """Per piece (M, n): square roots of the samples' weights."""
    residuals, keeps = [], []
    for rows in all_rows(pieces, layout):
        residuals.append(rows.residual(layout.of_joint, beta))
        keeps.append(rows.keep)
    size = np.array(
        [1.4826 * np.median(np.abs(_kept(residuals, keeps, j))) for j in range(layout.robot.n)]
    )
    limit = TUNING * np.maximum(size, 1e-300)
    return [np.sqrt(np.minimum(1.0, limit / np.maximum(np.abs(r), 1e-300))) for r in residuals]


def _kept(residuals: list[Array], keeps: list[NDArray[np.bool_]], joint: int) -> Array:
    return gathered([r[:, joint] for r in residuals], keeps, joint)
