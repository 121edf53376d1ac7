"""Weighted least squares of the model at hand, kept ready for adding one candidate.

Everything a candidate needs to be judged (Frisch-Waugh-Lovell) follows from the orthonormal
basis Q of the present columns: what the model absorbs of the candidate is Q·Qᵀc.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pa10d.diagnose.regression.side import Side
from pa10d.model import Unknowns
from pa10d.regression.per_joint import PerJoint, rms
from pa10d.regression.problem import Knowledge, LinearProblem
from pa10d.regression.solution import NO_COLUMN, Solution, asked_for

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LeastSquares(Solution):
    """Of τ on given columns over one side, whose rows are at hand.

    basis     joint -> (m_j, r): rows of the orthonormal basis of the weighted columns
    residual  joint -> (m_j,) weighted residual
    coordinates (r,): the target's in the basis; coefficients = to_beta @ coordinates
    """

    basis: PerJoint
    residual: PerJoint
    coordinates: Array

    def rms(self) -> Array:
        """(n,) N·m RMS of the unweighted residual per joint; σ itself where it has no row."""
        left = [rms(self.residual[j]) if self.rows[j] else 1.0 for j in range(len(self.sigma))]
        return np.asarray(left * self.sigma)

    @property
    def rows(self) -> list[int]:
        """m_j of every joint."""
        return [len(self.residual[j]) for j in range(len(self.sigma))]

    def without(self, columns: slice) -> LeastSquares:
        """The same least squares with some columns left out, by downdating the basis.

        The directions that only these columns reach are basis @ to_betaᵀ[columns]; a column of
        zeros reaches none.
        """
        reach = self.to_beta[columns]
        lost = np.linalg.qr(reach[reach.any(axis=1)].T)[0]
        basis, residual = {}, {}
        coordinates = self.coordinates
        back = lost.T @ coordinates
        for j, q in self.basis.items():
            own = q @ lost
            basis[j] = q - own @ lost.T
            residual[j] = self.residual[j] + own @ back
        kept = self.to_beta - (self.to_beta @ lost) @ lost.T
        rest = coordinates - lost @ back
        triangle = self.triangle.copy()
        triangle[:, columns] = 0.0
        return LeastSquares(
            sigma=self.sigma,
            basis=basis,
            to_beta=kept,
            beta=kept @ coordinates,
            residual=residual,
            coordinates=rest,
            triangle=triangle,
            target=self.target,
        )

    def leverage(self) -> Array:
        """(n,) share of the coefficients that each joint's equation had to pay for."""
        return np.array([float(np.sum(self.basis[j] ** 2)) for j in range(len(self.sigma))])


def least_squares(
    side: Side, columns: PerJoint, sigma: Array, known: Knowledge | None = None
) -> LeastSquares:
    """One weighted least-squares solution; near-null directions are truncated unless the data ask
    for them, as identification does it: else the search would be refused what the given model
    has, and say that the arm lacks it."""
    parts = [columns[j] / sigma[j] for j in range(side.n)]
    targets = [side.tau[j] / sigma[j] for j in range(side.n)]
    if known is not None:
        parts, targets = [*parts, known.wide(parts[0].shape[1])], [*targets, known.target]
    stacked, target = np.concatenate(parts), np.concatenate(targets)
    scale = np.linalg.norm(stacked, axis=0)
    empty = scale <= NO_COLUMN * scale.max(initial=0.0)
    stacked[:, empty], scale[empty] = 0.0, 1.0
    stacked /= scale
    size = stacked.shape[1]
    both = np.concatenate([stacked, target[:, None]], axis=1)
    whole = scipy.linalg.qr(both, mode="r", overwrite_a=True, check_finite=False)[0][:size]
    triangle = whole[:, :size]
    left, values, right = np.linalg.svd(triangle, full_matrices=False)
    along = left.T @ whole[:, size]
    told = np.zeros((0, size)) if known is None else known.wide(size) / scale
    kept = asked_for(values, along, np.linalg.norm(told @ right.T, axis=0))
    turn = right[kept].T / values[kept]
    basis = stacked @ turn
    # one step of refinement: R⁻¹ loses digits that the basis needs for what it leaves over
    correction = scipy.linalg.cholesky(basis.T @ basis, lower=False)
    basis = scipy.linalg.solve_triangular(correction, basis.T, trans=1, lower=False).T
    turn = scipy.linalg.solve_triangular(correction, turn.T, trans=1, lower=False).T
    coordinates = basis.T @ target
    residual = target - basis @ coordinates
    cuts = np.cumsum([len(side.tau[j]) for j in range(side.n)])
    to_beta = turn / scale[:, None]
    to_beta[empty] = 0.0
    return LeastSquares(
        sigma=sigma,
        basis=dict(enumerate(np.split(basis, cuts)[: side.n])),
        to_beta=to_beta,
        beta=to_beta @ coordinates,
        residual=dict(enumerate(np.split(residual, cuts)[: side.n])),
        coordinates=coordinates,
        triangle=triangle * scale,
        target=whole[:, size],
    )


def solved(
    side: Side,
    columns: PerJoint,
    problem: LinearProblem[Unknowns],
    start: Array | None = None,
) -> LeastSquares:
    """The weighted fit that a problem asks for; start: σ (n,) of the joints at first, where the
    residual is to say."""
    if problem.sigma is not None:
        return least_squares(side, columns, problem.sigma, problem.known)
    return iterated_fit(side, columns, start, problem.known)


def iterated_fit(
    side: Side,
    columns: PerJoint,
    sigma: Array | None = None,
    known: Knowledge | None = None,
    rounds: int = 3,
) -> LeastSquares:
    """Weighted fit with each joint's σ estimated from its own residual."""
    weights = np.array([max(float(np.std(tau)), 1e-9) if len(tau) else 1.0 for tau in side.tau])
    if sigma is not None:
        weights, rounds = sigma, 1
    fit = least_squares(side, columns, weights, known)
    for _ in range(rounds):
        smaller = np.maximum(fit.rms(), 1e-9)
        if np.all(np.abs(np.log(smaller / weights)) < 0.05):
            break
        weights = smaller
        fit = least_squares(side, columns, weights, known)
    return fit
