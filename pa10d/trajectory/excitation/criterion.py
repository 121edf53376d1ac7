"""What an exciting trajectory is judged by: the paper's equation 14, smooth, with its gradient.

The cost is λ1·cond(W) + λ2/σ_min(W) + λ3·(worst joint's standard error); or, for D-optimality,
minus the mean log singular value. Extremes are taken as p-norms of the singular values: at the
optimum several of them are nearly equal, and a gradient that knows only one of them zigzags. All
comes from the eigenvalues of WᵀW, whose loss of digits (cond² of some thousands) does not matter.

A condition number belongs to a choice of columns: the cost of a second base of the same space may
count as well, so that the motion is good in both.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.observation import ObservationColumns, change_of_base

Array = NDArray[np.float64]

JOINT_NORM = 8.0  # p of the worst joint
EDGE = 0.08  # of the boundary velocity, width over which a sample comes to count


@dataclass(frozen=True)
class Bases:
    """joint_of (k,): the joint each column belongs to; change (k, k): to the second base, whose
    joints are other_joint_of; None where there is but one."""

    joint_of: NDArray[np.int64]
    change: Array | None = None
    other_joint_of: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    @classmethod
    def of(cls, first: ObservationColumns, second: ObservationColumns) -> Bases:
        """The two bases; none second where they are the same."""
        if first.names() == second.names():
            return cls(first.joint_of())
        return cls(first.joint_of(), change_of_base(first, second), second.joint_of())


@dataclass(frozen=True)
class Criterion:
    """Weights and options; the defaults are the condition number alone.

    condition, smallest, evenness: λ1, λ2, λ3; determinant: minus mean log σ instead of these
    noise (n,) N·m: rows divided by it; boundary (n,) rad/s: only rows of joints faster than it
    above: share of the rows above the boundary in the (geometric) mean with all rows, 0 … 1
    scaled: columns to unit norm, so that units do not count
    second: share of the second base in the (geometric) mean of the costs, 0 … 1
    """

    condition: float = 1.0
    smallest: float = 0.0
    evenness: float = 0.0
    determinant: bool = False
    noise: Array | None = None
    boundary: Array | None = None
    above: float = 1.0
    scaled: bool = False
    second: float = 0.5

    def cost(
        self,
        matrix: Array,
        dq: Array,
        bases: Bases,
        sharpness: float,
    ) -> tuple[float, Array, Array]:
        """log of the cost, its gradient with respect to the matrix (N, n, k) and to dq (N, n).

        sharpness: p of the norms that stand in for largest and smallest.
        """
        if self.boundary is None:
            return self._of_rows(matrix, dq, None, bases, sharpness)
        value, push, from_dq = self._of_rows(matrix, dq, self.boundary, bases, sharpness)
        if self.above < 1.0:
            whole, pull, _ = self._of_rows(matrix, dq, None, bases, sharpness)
            value = self.above * value + (1.0 - self.above) * whole
            push = self.above * push + (1.0 - self.above) * pull
            from_dq = self.above * from_dq
        return value, push, from_dq

    def _of_rows(
        self, matrix: Array, dq: Array, boundary: Array | None, bases: Bases, sharpness: float
    ) -> tuple[float, Array, Array]:
        row, row_slope = self._weights(dq, boundary)
        weighed = (matrix * row[:, :, None]).reshape(-1, matrix.shape[2])
        value, slope = self._of_gram(weighed.T @ weighed, bases, sharpness)
        from_weighed = (2.0 * weighed @ slope).reshape(matrix.shape)
        from_dq = np.zeros_like(dq)
        if boundary is not None:
            from_dq = np.einsum("snc,snc->sn", from_weighed, matrix) * row_slope
        return value, from_weighed * row[:, :, None], from_dq

    def _weights(self, dq: Array, boundary: Array | None) -> tuple[Array, Array]:
        """Weight of each row, and its derivative in dq."""
        weight, slope = np.ones_like(dq), np.zeros_like(dq)
        if self.noise is not None:
            weight = weight / self.noise
        if boundary is not None:
            width = np.maximum(EDGE * boundary, 1e-4)
            rise = 0.5 * (1.0 + np.tanh((np.abs(dq) - boundary) / width))
            slope = weight * 2.0 * rise * (1.0 - rise) / width * np.sign(dq)
            weight = weight * rise
        return weight, slope

    def _of_gram(self, gram: Array, bases: Bases, p: float) -> tuple[float, Array]:
        """log cost and its derivative in the Gram matrix (k, k), both bases."""
        value, slope = self._scaled(gram, bases.joint_of, p)
        if bases.change is not None and self.second > 0 and not self.determinant:
            t = bases.change
            other, push = self._scaled(t.T @ gram @ t, bases.other_joint_of, p)
            value += self.second * (other - value)
            slope = slope + self.second * (t @ push @ t.T - slope)
        return value, slope

    def _scaled(self, gram: Array, joint_of: NDArray[np.int64], p: float) -> tuple[float, Array]:
        if not self.scaled:
            return self._log_cost(gram, joint_of, p)
        norms = np.sqrt(np.maximum(np.diag(gram), 1e-24))
        unit = gram / np.outer(norms, norms)
        value, slope = self._log_cost(unit, joint_of, p)
        pull = np.diag(np.sum(slope * unit, axis=1))
        return value, (slope - pull) / np.outer(norms, norms)

    def _log_cost(self, gram: Array, joint_of: NDArray[np.int64], p: float) -> tuple[float, Array]:
        """From the eigenvalues σ² of the Gram matrix; d(σ²) = vᵀ·dGram·v."""
        values, vectors = np.linalg.eigh(gram)
        values = np.maximum(values, 1e-14 * values[-1])
        s = np.sqrt(values)
        if self.determinant:
            inner = (vectors * (-0.5 / (len(s) * values))) @ vectors.T
            return float(-np.mean(np.log(s))), inner
        up = (s / s[-1]) ** p
        down = (s[0] / s) ** p
        largest = s[-1] * up.sum() ** (1 / p)
        inverse = down.sum() ** (1 / p) / s[0]
        d_largest = largest * up / up.sum() / s  # d/dσ
        d_inverse = -inverse * down / down.sum() / s
        cost = self.condition * largest * inverse + self.smallest * inverse
        d_cost = self.condition * (d_largest * inverse + largest * d_inverse)
        d_cost += self.smallest * d_inverse
        slope = (vectors * (0.5 * d_cost / s)) @ vectors.T
        if self.evenness:
            error, d_error = worst_joint(values, vectors, joint_of)
            cost += self.evenness * error
            slope += self.evenness * d_error
        return float(np.log(cost)), slope / cost


def worst_joint(values: Array, vectors: Array, joint_of: NDArray[np.int64]) -> tuple[float, Array]:
    """Smooth maximum over joints of the RMS standard error of each joint's own parameters, and
    its derivative in the Gram matrix."""
    covariance = (vectors / values) @ vectors.T
    errors = joint_errors(covariance, joint_of)
    total = np.sum(errors**JOINT_NORM) ** (1 / JOINT_NORM)
    share = (errors / total) ** (JOINT_NORM - 1)
    weight = (share / (2 * errors * np.bincount(joint_of)))[joint_of]
    return float(total), -(covariance * weight) @ covariance


def joint_errors(covariance: Array, joint_of: NDArray[np.int64]) -> Array:
    """(n,) RMS over each joint's own parameters of their standard error at unit torque noise."""
    variance = np.bincount(joint_of, weights=np.diag(covariance))
    return np.asarray(np.sqrt(variance / np.bincount(joint_of)))
