"""Weighted least squares from the joints' triangular factors.

The weights are one number per joint, so the factors are computed once and every further round
of weights costs a few milliseconds, whatever the number of samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pa10d.regression.problem import Knowledge
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]
Indices = Sequence[NDArray[np.int64]]
"""Per joint: which unknowns the columns of its equation belong to."""

NEAR_NULL = 1e-5  # of the largest singular value: motion too poor to tell
ROUNDED = 1e-12  # of the target: less of it than that is left by nothing but chance
NUMERICAL = 1e-10  # of the largest singular value: nothing but rounding
DEMANDED = 10.0  # standard deviations of the noise by which data must ask for a near-null direction
HELD = 0.5**0.5  # of a singular value: half of what is known of a direction was known beforehand
MOVED = 1e-3  # share of a truncated direction; what rounding mixes into it is a millionth of that
ROUNDS = 2
NO_COLUMN = 1e-12  # of the largest column: what a joint that never moves leaves of its own, rounded


@dataclass(frozen=True)
class Solution:
    """What weighted least squares found, whoever solved it.

    beta (p,) unknowns; sigma (n,) N·m the joints' weights are 1/σ²
    to_beta (p, r): directions that were solved for, each scaled to unit variance under the
    weights, so that to_beta @ to_betaᵀ is the covariance of beta for independent errors
    triangle (≤p, p), target (≤p,): the whole weighted problem in triangular form, ‖T·β - y‖² but
    for what no β explains, near-null directions and prior knowledge included
    """

    beta: Array
    sigma: Array
    to_beta: Array
    triangle: Array
    target: Array

    @property
    def rank(self) -> int:
        """Number of directions solved for."""
        return self.to_beta.shape[1]

    def covariance(self) -> Array:
        """(p, p) for unit-variance independent errors; the caller knows better about noise."""
        return np.asarray(self.to_beta @ self.to_beta.T)


@dataclass(frozen=True)
class Streamed(Solution):
    """From triangular factors of rows that nobody holds any more.

    lost (p, p-r): orthonormal directions in column-scaled unknowns that were truncated
    values (p,): singular values of the column-scaled weighted matrix, largest first
    scale (p,): norms of the weighted columns; unknown = scaled unknown / scale
    """

    lost: Array
    values: Array
    scale: Array

    @property
    def open(self) -> NDArray[np.int64]:
        """Unknowns that a truncated direction moves: the data leave them open."""
        return np.flatnonzero(np.linalg.norm(self.lost, axis=1) > MOVED)


def strong(values: Array) -> NDArray[np.bool_]:
    """(p,) which directions of a column-scaled matrix are solved for, by its singular values (p,),
    largest first."""
    return np.asarray(values > NEAR_NULL * values[0])


def asked_for(values: Array, along: Array, held: Array | float = 0.0) -> NDArray[np.bool_]:
    """(p,) which directions of a column-scaled weighted matrix are solved for; along (p,): the
    target's coordinates in them, in standard deviations of the noise; held (p,): singular values of
    what was known beforehand.

    The strong ones. Of the near-null ones, if they are more than rounding, those along which the
    target has a part far above the noise, and those of which most is known beforehand, so that
    noise cannot run along them.
    """
    more = (np.abs(along) > DEMANDED) | (held > HELD * values)
    return np.asarray(strong(values) | ((values > NUMERICAL * values[0]) & more))


def estimate_weights(
    moving: Sequence[Triangle],
    rest: Sequence[Triangle],
    indices: Indices,
    size: int,
    known: Knowledge | None = None,
) -> Array:
    """σ_j (n,) N·m of every joint: the spread of its residual about its mean over moving and
    resting samples alike, two rounds from an unweighted fit with what is known beforehand.

    Further rounds would let a joint that happens to fit well dictate what all others share. An
    offset that the model lacks is not noise, hence the spread about the mean; what friction does
    at rest is not fitted, but tells how far a joint is to be trusted.
    """
    sigma = np.ones(len(moving))
    for _ in range(ROUNDS):
        sigma = spread(moving, rest, indices, solve(moving, indices, size, sigma, known).beta)
    return sigma


def spread(
    moving: Sequence[Triangle], rest: Sequence[Triangle], indices: Indices, beta: Array
) -> Array:
    """(n,) standard deviation of each joint's residual, never quite zero."""
    variance, torque = np.empty(len(moving)), np.empty(len(moving))
    for j, (a, b, index) in enumerate(zip(moving, rest, indices, strict=True)):
        x = np.append(-beta[index], 1.0)
        unit = np.append(np.zeros(len(index)), 1.0)
        count = max(a.rows + b.rows, 1)
        mean = float((a.sums + b.sums) @ x) / count
        variance[j] = (a.squares(x) + b.squares(x)) / count - mean**2
        torque[j] = (a.squares(unit) + b.squares(unit)) / count
    floor = np.maximum(1e-26 * torque, 1e-24 * float(torque.max()))
    return np.asarray(np.sqrt(np.maximum(variance, floor)))


def solve(
    factors: Sequence[Triangle],
    indices: Indices,
    size: int,
    sigma: Array,
    known: Knowledge | None = None,
) -> Streamed:
    """Least squares over all joints, joint j weighted by 1/σ_j², with what is known beforehand.

    factors[j]: of [columns, torque] of joint j

    Rank: directions that ``asked_for`` says. Structural dependencies are gone before (base
    parameters); what is left near null is motion that was too poor, along which noise would be
    amplified without bound. Orthogonal reduction keeps singular values down to 1e-15 of the
    largest, where a Gram matrix would end at 1e-8.
    """
    told = np.zeros((0, size)) if known is None else known.wide(size)
    count = len(told) + sum(len(f.r) for f in factors)
    stacked = np.zeros((max(count, size + 1), size + 1))
    start = len(told)  # the firmest rows come first: the reduction then loses no digits to them
    if known is not None:
        stacked[:start] = np.column_stack([told, known.target])
    for factor, index, s in zip(factors, indices, sigma, strict=True):
        part = slice(start, start + len(factor.r))
        stacked[part, index] = factor.r[:, :-1] / s
        stacked[part, -1] = factor.r[:, -1] / s
        start += len(factor.r)
    shown = np.linalg.norm(stacked[len(told) :, :-1], axis=0)
    stacked[len(told) :, :-1][:, shown <= NO_COLUMN * shown.max(initial=0.0)] = 0.0
    scale = np.linalg.norm(stacked[:, :-1], axis=0)
    scale[scale == 0] = 1.0
    stacked[:, :-1] /= scale
    whole = scipy.linalg.qr(stacked, mode="r", check_finite=False)[0]
    triangle, target = whole[:size, :-1], whole[:size, -1]
    rows = max(sum(f.rows for f in factors) - size, 1)
    rounded = ROUNDED * max(float(np.abs(target).max()), 1e-200)
    noise = max(abs(float(whole[size, -1])) / np.sqrt(rows), rounded)
    left, values, right = np.linalg.svd(triangle)
    along = left.T @ target
    solved = asked_for(values, along / noise, np.linalg.norm(told / scale @ right.T, axis=0))
    turn = right[solved].T / values[solved] / scale[:, None]
    beta = turn @ along[solved]
    return Streamed(beta, sigma, turn, triangle * scale, target, right[~solved].T, values, scale)
