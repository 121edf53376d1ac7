"""What a part of the samples asks for by itself, beside a fit that all of them share."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import ABSORBED, CLUSTERS
from pa10d.diagnose.evidence.held_out import judge
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.side import Side
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OwnPart:
    """What a part of the samples has for itself, beside the fit: theta (k,) of its columns; change,
    joint -> (m_j,) weighted, of what the fit leaves; basis, joint -> (m_j, d) orthonormal, of all
    that it could change; free: (k, d), how theta moves along that."""

    gain: float
    theta: Array
    change: PerJoint
    basis: PerJoint
    free: Array

    @property
    def size(self) -> int:
        """Free numbers that it spends."""
        return int(next(iter(self.basis.values())).shape[1])


def own_part(fit: LeastSquares, own: PerJoint) -> OwnPart | None:
    """Of weighted columns (m_j, k), whatever scale they have; None where all of it is in the fit
    already."""
    power = np.sum([np.sum(c**2, axis=0) for c in own.values()], axis=0)
    scale = np.sqrt(np.where(power > 0.0, power, 1.0))
    seen = np.sum([fit.basis[j].T @ c for j, c in own.items()], axis=0) / scale
    gram = np.sum([c.T @ c for c in own.values()], axis=0) / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(gram - seen.T @ seen)
    there = values > ABSORBED
    if not there.any():
        return None
    turn = vectors[:, there] / np.sqrt(values[there])
    basis = {}
    for j, q in fit.basis.items():
        basis[j] = -(q @ (seen @ turn))
        if j in own:
            basis[j] = basis[j] + own[j] @ (turn / scale[:, None])
    along = np.sum([b.T @ fit.residual[j] for j, b in basis.items()], axis=0)
    change = {j: b @ along for j, b in basis.items()}
    free = turn / scale[:, None]
    return OwnPart(float(along @ along), free @ along, change, basis, free)


def lasting(side: Side, fit: LeastSquares, part: OwnPart) -> bool:
    """Does it hold from one stretch of time to the next? What a model lacks bends to it here and
    away from it there."""
    evidence = judge(
        side,
        {j: r * fit.sigma[j] for j, r in fit.residual.items()},
        {j: c * fit.sigma[j] for j, c in part.change.items()},
    )
    return evidence.cluster_t > CLUSTERS


def beside(fit: LeastSquares, part: OwnPart) -> LeastSquares:
    """The fit with that in it; its coefficients stay as they were."""
    return replace(
        fit,
        basis={j: np.column_stack([q, part.basis[j]]) for j, q in fit.basis.items()},
        residual={j: r - part.change[j] for j, r in fit.residual.items()},
    )
