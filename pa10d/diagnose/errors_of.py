"""Standard errors of a term's coefficients and shapes under autocorrelated noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.evidence import Doubt
from pa10d.diagnose.fit import Fit
from pa10d.diagnose.side import PerJoint, Side
from pa10d.diagnose.state import State
from pa10d.identify.spectrum import autocovariance, coloured_gram, correlation_length, flat_top
from pa10d.model import Term

Array = NDArray[np.float64]

LONGEST_SECONDS = 4.0


def full_covariance(state: State, fit: Fit | None = None) -> Array:
    """(p, p) of all coefficients: (XᵀX)⁻¹ XᵀΣX (XᵀX)⁻¹ with Σ from the residuals themselves.

    fit: another one of the same columns, some of them left out.
    """
    fit = state.fit if fit is None else fit
    middle = noise_gram(state.train, fit, fit.basis)
    if state.prior is not None:
        # what the prior knew already is as certain as it said
        top = np.sum([q.T @ q for q in fit.basis.values()], axis=0)
        middle = middle + np.eye(len(top)) - top
    return np.asarray(fit.to_beta @ middle @ fit.to_beta.T)


def doubt_of(state: State, fit: Fit | None = None) -> Doubt:
    """How uncertain the model is on the held-out side."""
    return Doubt(state.held_matrix, full_covariance(state, fit))


def term_covariance(state: State, index: int) -> tuple[Array, dict[str, float]]:
    """Covariance (k, k) of a term's coefficients with its shape free, and the shape's errors."""
    term = state.terms[index]
    place = state.place(index)
    free = [s for s in term.effect.shapes if s.scale != "choice" and s.name in term.shape]
    rest = state.fit.without(place)
    columns = dict(state.blocks[index][0])
    k = len(term.coefficients)
    if free:
        slopes = [_slope(state, term, s.name, s.lower, s.upper) for s in free]
        columns = {
            j: np.column_stack([columns[j], *[d.get(j, np.zeros(len(columns[j]))) for d in slopes]])
            for j in columns
        }
    left: PerJoint = {}
    seen = sum(rest.basis[j].T @ (c / rest.sigma[j]) for j, c in columns.items())
    for j in range(state.train.n):
        own = columns.get(j)
        absorbed = rest.basis[j] @ seen
        left[j] = -absorbed if own is None else own / rest.sigma[j] - absorbed
    gram = sum(c.T @ c for c in left.values())
    if state.prior is not None:
        gram = _gram_with_prior(columns, rest, seen)
    inverse = np.linalg.pinv(gram, rcond=1e-12, hermitian=True)
    covariance = inverse @ noise_gram(state.train, state.fit, left) @ inverse
    if state.prior is not None:
        covariance = covariance + inverse @ (gram - sum(c.T @ c for c in left.values())) @ inverse
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    shape_errors = {s.name: float(e) for s, e in zip(free, errors[k:], strict=True)}
    return covariance[:k, :k], shape_errors


def noise_gram(side: Side, fit: Fit, columns: PerJoint) -> Array:
    """Σ_j Cᵀ Γ_j C for weighted columns and the whitened residual's autocovariance Γ_j."""
    total: Array | float = 0.0
    widths = next(iter(columns.values())).shape[1]
    for j, c in columns.items():
        rates = side.runs[0].rate
        residual = side.scatter({j: fit.residual[j]})
        keep = [k[:, j] for k in side.keep]
        longest = int(min(LONGEST_SECONDS * rates, min(len(k) for k in keep) // 4))
        gamma, count = autocovariance(
            ((r[:, j], k) for r, k in zip(residual, keep, strict=True)), longest
        )
        gamma = flat_top(gamma, correlation_length(gamma, count))
        start = 0
        for k in keep:
            rows = int(k.sum())
            spread = np.zeros((len(k), widths))
            spread[k] = c[start : start + rows]
            total = total + coloured_gram(spread, gamma)
            start += rows
    return np.asarray(total)


def _gram_with_prior(columns: PerJoint, rest: Fit, seen: Array) -> Array:
    own = sum((c / rest.sigma[j]).T @ (c / rest.sigma[j]) for j, c in columns.items())
    return np.asarray(own - seen.T @ seen)


def _slope(state: State, term: Term, name: str, lower: float, upper: float) -> PerJoint:
    """∂(torque of the term)/∂shape on the training side, joint -> (m_j,)."""
    value = term.shape[name]
    step = 1e-3 * max(abs(value), 1e-3 * (upper - lower))
    ends = []
    for sign in (1.0, -1.0):
        shape = {**term.shape, name: float(np.clip(value + sign * step, lower, upper))}
        columns = state.train.columns(term.effect, term.joints, [shape])
        ends.append((shape[name], {j: c @ term.coefficients for j, c in columns.items()}))
    width = ends[0][0] - ends[1][0]
    zero = {j: np.zeros(len(state.train.tau[j])) for j in range(state.train.n)}
    return {
        j: (ends[0][1].get(j, zero[j]) - ends[1][1].get(j, zero[j])) / width
        for j in {**ends[0][1], **ends[1][1]}
    }
