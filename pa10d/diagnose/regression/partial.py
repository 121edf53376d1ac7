"""What a candidate adds that the present model cannot absorb (Frisch-Waugh-Lovell)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import ABSORBED
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.effects import Effect
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PartialFit:
    """k candidate columns beside the model, in whitened units.

    gram (k, k) and rhs (k,): normal equations of what the model leaves over of the columns
    seen (r, k): basis coordinates of the columns, what the model would absorb
    theta (k,): bounded least-squares coefficients; gain: drop of the weighted squared error
    """

    gram: Array
    rhs: Array
    seen: Array
    theta: Array
    gain: float
    identifiable: bool


def partials(
    fit: LeastSquares,
    columns: PerJoint,
    effect: Effect,
    width: int,
    *,
    falls: bool = False,
    least: float = ABSORBED,
) -> list[PartialFit]:
    """Judge several shapes of one effect at once: their columns lie side by side in ``columns``,
    ``width`` = number of coefficients each; falls: they are the change of what is there already,
    and have no lower bound; least: share of a column's power that the model has to leave."""
    total = next(iter(columns.values())).shape[1]
    rank = fit.to_beta.shape[1]
    seen, rhs = np.zeros((rank, total)), np.zeros(total)
    own = np.zeros((total // width, width, width))
    for j, c in columns.items():
        weighted = c / fit.sigma[j]
        seen += fit.basis[j].T @ weighted
        rhs += weighted.T @ fit.residual[j]
        parts = weighted.reshape(len(weighted), weighted.shape[1] // width, width)
        own += np.einsum("msk,msl->skl", parts, parts)
    lower = np.array([-np.inf if falls else c.lower for c in effect.coefficients])
    upper = np.array([c.upper for c in effect.coefficients])
    out = []
    for s in range(total // width):
        part = slice(s * width, (s + 1) * width)
        gram = own[s] - seen[:, part].T @ seen[:, part]
        power = np.diag(own[s])
        theta, here = np.zeros(width), power > 0  # a coefficient may have no column: it stays zero
        if not here.any() or np.min(np.diag(gram)[here] / power[here]) < least:
            out.append(PartialFit(gram, rhs[part], seen[:, part], theta, 0.0, False))
            continue
        theta[here] = bounded(gram[np.ix_(here, here)], rhs[part][here], lower[here], upper[here])
        gain = float(2 * theta @ rhs[part] - theta @ gram @ theta)
        out.append(PartialFit(gram, rhs[part], seen[:, part], theta, gain, True))
    return out


def normal_equations(fit: LeastSquares, columns: PerJoint) -> tuple[Array, Array]:
    """Gram matrix (k, k) and right side (k,) of what ``fit`` leaves over of k columns."""
    weighted = {j: c / fit.sigma[j] for j, c in columns.items()}
    seen = np.asarray(sum(fit.basis[j].T @ c for j, c in weighted.items()))
    gram = sum(c.T @ c for c in weighted.values()) - seen.T @ seen
    rhs = sum(c.T @ fit.residual[j] for j, c in weighted.items())
    return np.asarray(gram), np.asarray(rhs)


def bounded(gram: Array, rhs: Array, lower: Array, upper: Array) -> Array:
    """argmin ½ θᵀGθ - rhsᵀθ within a box, exact for the few coefficients an effect has."""
    theta = solve_symmetric(gram, rhs)
    if np.all(theta >= lower) and np.all(theta <= upper):
        return theta
    best, best_value = np.clip(theta, lower, upper), np.inf
    options = [
        [None, *(b for b in (lower[i], upper[i]) if np.isfinite(b))] for i in range(len(rhs))
    ]
    for choice in product(*options):
        fixed = np.array([c is not None for c in choice])
        trial = np.array([0.0 if c is None else c for c in choice])
        free = ~fixed
        if free.any():
            trial[free] = solve_symmetric(
                gram[np.ix_(free, free)], rhs[free] - gram[np.ix_(free, fixed)] @ trial[fixed]
            )
        if np.any(trial < lower - 1e-12) or np.any(trial > upper + 1e-12):
            continue
        value = 0.5 * trial @ gram @ trial - rhs @ trial
        if value < best_value:
            best, best_value = trial, value
    return best


def solve_symmetric(gram: Array, rhs: Array) -> Array:
    """Symmetric solve that drops directions lost in rounding."""
    scale = column_scale(gram)
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    strong = values > 1e-8 * max(values[-1], 1e-300)
    turned = vectors[:, strong].T @ (rhs / scale)
    return np.asarray(vectors[:, strong] @ (turned / values[strong]) / scale)


def column_scale(gram: Array) -> Array:
    """(k,) lengths of the columns of a Gram matrix; 1 of a column without any."""
    power = np.diag(gram)
    return np.asarray(np.sqrt(np.where(power > 0.0, power, 1.0)))
