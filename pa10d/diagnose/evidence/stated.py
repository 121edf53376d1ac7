"""Standard errors as a model states them and as its findings print them: one covariance for both.

Shapes were fitted like coefficients, and make these and all others less certain; what reversals do
to an effect's estimates (0070, rule 23), what a curve over an angle leaves open, and how late and
how smooth the torque's channel makes it, or may make it, are in it, too. So a parameter has one
error, whoever tells of it.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.evidence.curves import open_to_curves
from pa10d.diagnose.evidence.errors_of import (
    certain_before,
    covariance_under,
    shape_errors_of,
)
from pa10d.diagnose.evidence.reversals import moved_by_reversals
from pa10d.diagnose.regression.behind import channel_slopes, perhaps_smoothed
from pa10d.diagnose.regression.shapes import free_shapes
from pa10d.diagnose.regression.slopes import with_slopes
from pa10d.diagnose.regression.state import SearchState
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stated:
    """covariance (p, p) of all coefficients, the shapes of the terms at hand being free;
    shape_errors: index of a term -> name -> standard error, of those that have free shapes."""

    covariance: Array
    shape_errors: dict[int, dict[str, float]]


def stated(state: SearchState, fresh: Collection[int], of_law: bool = True) -> Stated:
    """fresh: indices of the terms whose shapes these data have settled; of_law: whether one law of
    such an effect may as well be another (``certain_before``)."""
    state = state.as_free()
    fit, width = state.fit, state.fit.to_beta.shape[1]
    corners = corners_beside(state, fresh)
    slopes = {i: _slopes(state, i) for i in [*sorted(fresh), *corners]}
    places, total = {}, 0
    for i, of_term in slopes.items():
        count = next(iter(of_term.values())).shape[1]
        places[i] = slice(total, total + count)
        total += count
    of_shapes, perhaps = total, perhaps_smoothed(state)
    channel = {j: np.column_stack([c, perhaps[j]]) for j, c in channel_slopes(state).items()}
    total += next(iter(channel.values())).shape[1]
    unknown = total - next(iter(perhaps.values())).shape[1]  # from here on: there, or not
    columns: PerJoint = {}
    weighted = {j: np.column_stack([np.zeros((len(c), of_shapes)), c]) for j, c in channel.items()}
    for i, of_term in slopes.items():
        for j, own in of_term.items():
            weighted[j][:, places[i]] = own / fit.sigma[j]
    precision = np.zeros(total)  # of what is known besides these data
    precision[unknown:] = 1.0
    for i in sorted(fresh):
        precision[places[i]] = certain_before(state.terms[i], of_law)
    for i, error in corners.items():  # as identification knows them, which saw reversals, too
        precision[places[i]] = 1.0 / error**2
    power = precision + np.sum([np.sum(w**2, axis=0) for w in weighted.values()], axis=0)
    size = np.sqrt(np.where(power > 0.0, power, 1.0))  # a shape may move nothing
    seen = np.sum([fit.basis[j].T @ (w / size) for j, w in weighted.items()], axis=0)
    for j, w in weighted.items():
        columns[j] = np.column_stack([fit.basis[j], w / size - fit.basis[j] @ seen])
    top = np.sum([q.T @ q for q in fit.basis.values()], axis=0)
    prior = np.column_stack([np.eye(width), -seen])  # rows of what was known, in the basis
    prior = prior.T @ (np.eye(width) - top) @ prior
    gram = np.sum([c[:, width:].T @ c[:, width:] for c in columns.values()], axis=0)
    if state.problem.known is not None:
        gram = gram + prior[width:, width:]
    else:
        prior = np.zeros_like(prior)
    gram += np.diag(precision / size**2)
    prior[width:, width:] += np.diag(precision / size**2)
    inverse = np.linalg.pinv(gram, rcond=1e-12, hermitian=True)
    turn = np.block(
        [[fit.to_beta, -fit.to_beta @ seen @ inverse], [np.zeros((total, width)), inverse]]
    )
    whole = covariance_under(state, columns, turn, turn @ prior @ turn.T)
    for index in range(width + unknown, width + total):  # what it seems to be, unknown to the rest
        moved = turn[:, index] * sum(c[:, index] @ fit.residual[j] for j, c in columns.items())
        whole += np.outer(moved, moved)
    count = len(fit.to_beta)
    shapes = slice(count, None)
    whole[shapes] /= size[:, None]
    whole[:, shapes] /= size
    whole[:count, :count] += open_to_curves(state, fresh)
    told = {i: of_term for i, of_term in slopes.items() if i not in corners}
    return _with_reversals(state, whole, told, {i: _after(places[i], count) for i in told})


def corners_beside(state: SearchState, fresh: Collection[int]) -> dict[int, float]:
    """Index -> standard error, rad/s (m/s), infinite where nobody knows: of the corners over which
    dry friction turns round where friction was found that does so, too. It was fitted beside them.
    """
    there = {state.terms[i].joints for i in fresh if state.terms[i].effect.carried}
    out = {}
    for index, term in enumerate(state.terms):
        over = term.effect.smoothed_over
        free = over and [s.name for s in free_shapes(term.effect, term.shape)] == [over]
        if free and index not in fresh and term.joints in there:
            error = term.shape_errors.get(over, np.inf)
            out[index] = error if error > 0.0 else np.inf
    return out


def _with_reversals(
    state: SearchState, whole: Array, slopes: dict[int, PerJoint], places: dict[int, slice]
) -> Stated:
    count = len(state.fit.to_beta)
    errors = {}
    for i, of_term in slopes.items():
        own = np.r_[state.place(i), places[i]]
        moved = moved_by_reversals(state, i, of_term, np.diag(whole)[own])
        whole[own, own] += moved
    for i in slopes:
        found = np.sqrt(np.maximum(np.diag(whole)[places[i]], 0.0))
        errors[i] = shape_errors_of(state, state.terms[i], found)
    return Stated(whole[:count, :count], {i: e for i, e in errors.items() if e})


def _slopes(state: SearchState, index: int) -> PerJoint:
    """joint -> (m_j, s): how a term's torque moves with its free shapes."""
    term = state.terms[index]
    if not free_shapes(term.effect, term.shape):
        return {j: np.zeros((len(c), 0)) for j, c in state.blocks[index][0].items()}
    columns = with_slopes(state.train, term)
    return {j: c[:, len(term.coefficients) :] for j, c in columns.items()}


def _after(place: slice, count: int) -> slice:
    return slice(count + place.start, count + place.stop)
