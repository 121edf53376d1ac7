"""Weighted least squares of a whole layout, with honest errors."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.pseudo_inertia import definiteness
from pa10d.identify.blocks import Pieces
from pa10d.identify.rows import Rows, all_rows, rows_of, triangles_of
from pa10d.identify.smoothing import Smoothing
from pa10d.regression.bodies import widely
from pa10d.regression.covariance import Uncertainty, WeightedStretch, uncertainty
from pa10d.regression.lacking import Stretch
from pa10d.regression.layout import Layout
from pa10d.regression.problem import Knowledge, LinearProblem
from pa10d.regression.solution import HELD, Indices, Solution, Streamed, estimate_weights, solve
from pa10d.regression.told import added_ones, left_open
from pa10d.regression.triangle import Triangle
from pa10d.regression.unseen_load import unseen_load

Array = NDArray[np.float64]

MINDS = 0.02  # share by which the error of a joint may rise for bodies that are known beforehand


@dataclass(frozen=True)
class Fit:
    """Solution for the layout's unknowns and their uncertainty.

    rms, torque (n,) N·m of the filtered residual and torque over the fitted samples
    factors[j]: triangular factor of [columns, torque] of joint j
    open: (p,) unknowns that the data leave open
    """

    solution: Streamed
    uncertainty: Uncertainty
    rms: Array
    torque: Array
    factors: tuple[Triangle, ...]
    open: NDArray[np.bool_]

    def rms_of(self, beta: Array, indices: Indices) -> Array:
        """(n,) N·m: RMS that other values of the unknowns would leave."""
        return rms_of(self.factors, indices, beta)


def plain_fit(pieces: Pieces, layout: Layout) -> Array:
    """(p,) the weighted solution alone, from an even selection of the data."""
    moving, rest = _triangles(rows_of(piece, layout) for piece in pieces.some())
    sigma = estimate_weights(moving, rest, layout.of_joint, layout.size)
    return solve(moving, layout.of_joint, layout.size, sigma).beta


def trust(pieces: Pieces, layout: Layout, bodies: Knowledge | None) -> tuple[Array, Array]:
    """(n,) N·m by which each joint is weighted: what an even selection of the data leaves of it, at
    rest and in motion; and the same with what is known of bodies. Where joints move one by one, a
    fit to motion alone may say anything of the poses in which they stand."""
    moving, rest = _triangles(rows_of(piece, layout) for piece in pieces.some())
    alone = estimate_weights(moving, rest, layout.of_joint, layout.size)
    if bodies is None:
        return alone, alone
    return alone, estimate_weights(moving, rest, layout.of_joint, layout.size, bodies)


def weighted_fit(
    pieces: Pieces,
    problem: LinearProblem[Layout],
    smoothing: Smoothing,
    weights: Sequence[Array] | None = None,
) -> Fit:
    """Fit all unknowns; each v0 that was found counts as one more unknown when the
    errors are worked out, because it makes the others less certain.

    weights: per piece (M, n), by which rows are multiplied beside 1/σ of their joint
    """
    layout, known = problem.unknowns, problem.known

    def stretches(bent: NDArray[np.bool_] | None = None) -> Iterator[Rows]:
        whole = all_rows(pieces, layout, bent)
        if weights is None:
            return whole
        return (rows.times(w) for rows, w in zip(whole, weights, strict=True))

    inner, size = layout.of_joint, layout.size
    found = np.flatnonzero(smoothing.found)
    outer = [
        np.append(index, size + np.searchsorted(found, j)) if smoothing.found[j] else index
        for j, index in enumerate(inner)
    ]
    moving, rest = _triangles(stretches(smoothing.found))
    plain = tuple(t.without(np.s_[len(i) : -1]) for t, i in zip(moving, inner, strict=True))
    still = tuple(t.without(np.s_[len(i) : -1]) for t, i in zip(rest, inner, strict=True))
    sigma = problem.sigma
    if sigma is None:
        sigma = estimate_weights(plain, still, inner, size)
    solution = solve(plain, inner, size, sigma, known)
    wide = solve(moving, outer, size + len(found), sigma, known)
    residuals, keeps, peaks = [], [], np.zeros((len(inner), size))
    for rows in stretches():
        residuals.append(rows.residual(inner, solution.beta))
        keeps.append(rows.keep)
        for j, index in enumerate(inner):
            most = np.abs(rows.columns[j][rows.keep[:, j]]).max(axis=0, initial=0.0)
            peaks[j, index] = np.maximum(peaks[j, index], most)
    motion = [
        Stretch.of(piece.equation, residual, keep)
        for piece, residual, keep in zip(pieces, residuals, keeps, strict=True)
    ]
    inverse = wide.covariance()
    beyond = unseen_load(layout, solution.beta, moving, outer, wide.sigma, inverse)
    if known is not None:
        beyond += inverse @ known.scatter(len(inverse)) @ inverse
    uncertain = uncertainty(
        motion,
        lambda: (_seen(rows, outer, wide) for rows in stretches(smoothing.found)),
        [inverse[:, index] for index in outer],
        wide.sigma,
        _leverage(moving, outer, wide),
        pieces.lowpass,
        beyond,
    )
    rms = rms_of(plain, inner, solution.beta)
    torque = rms_of(plain, inner, np.zeros(size))
    stated = uncertain.first(size)
    sizes = np.sqrt(np.maximum(np.diag(stated.covariance), 0.0))
    added = added_ones(len(layout.base), layout.terms)
    open_ = left_open(solution.beta, sizes, peaks, torque, rms, added)
    open_[solution.open] = True
    return Fit(solution, stated, rms, torque, plain, open_)


def wide_bodies(layout: Layout) -> Knowledge | None:
    """Of the base parameters: that bodies are the robot's file's, give or take more than anybody
    doubts. None where the file has none that can exist."""
    if np.any(definiteness(layout.robot.parameters) <= 0.0):
        return None
    return widely(layout.robot.parameters, layout.robot, layout.base)


def beside_bodies(free: Fit, bodies: Knowledge, refitted: Callable[[Knowledge | None], Fit]) -> Fit:
    """The fit, beside bodies where along some direction the data say less than is known of them:
    noise alone would lead it there to links of tons. The data's own fit where all directions are
    seen, and where any joint would mind. What the data leave open stays so.

    refitted: with the weights that joints have beside bodies, and with these bodies or without
    """
    if not mostly_known(free.solution.triangle, bodies.rows):
        return free
    held = refitted(bodies)
    if np.any(held.rms > (1.0 + MINDS) * refitted(None).rms):
        return free
    solution = replace(held.solution, lost=free.solution.lost)
    return replace(held, solution=solution, open=held.open | free.open)


def mostly_known(triangle: Array, rows: Array) -> bool:
    """Is more known of some direction of the first unknowns beforehand, by rows (k, b), than the
    data say, ‖triangle·β - y‖² with triangle (m, p), whatever the others are?"""
    count = rows.shape[1]
    turned = np.hstack([triangle[:, count:], triangle[:, :count]])
    said = np.asarray(np.linalg.qr(turned, mode="r"))[-count:, -count:]
    basis = np.asarray(np.linalg.qr(np.vstack([said, rows]))[0])
    return bool(np.linalg.norm(basis[len(said) :], 2) > HELD)


def rms_of(factors: Sequence[Triangle], indices: Indices, beta: Array) -> Array:
    """(n,) N·m RMS of each joint's residual."""
    squares = [f.squares(np.append(-beta[i], 1.0)) for f, i in zip(factors, indices, strict=True)]
    return np.sqrt(np.array(squares) / np.maximum([f.rows for f in factors], 1))


def _seen(rows: Rows, indices: Indices, solution: Solution) -> list[WeightedStretch]:
    """Of one stretch: the columns of every joint under its weight."""
    out = []
    for j, index in enumerate(indices):
        keep, sigma, columns = rows.keep[:, j], solution.sigma[j], rows.columns[j]
        weighted = np.where(keep[:, None], columns / sigma, 0.0)
        out.append(
            WeightedStretch(weighted, partial(_times, weighted[keep], solution.to_beta[index]))
        )
    return out


def _times(columns: Array, turn: Array) -> Array:
    return np.asarray(columns @ turn)


def _triangles(stretches: Iterable[Rows]) -> tuple[list[Triangle], list[Triangle]]:
    moving: list[Triangle] = []
    rest: list[Triangle] = []
    for rows in stretches:
        triangles_of([rows], into=moving)
        triangles_of([rows], rest=True, into=rest)
    return moving, rest


def _leverage(factors: Sequence[Triangle], indices: Indices, solution: Solution) -> Array:
    """(n,) share of the unknowns that each joint's equation had to pay for."""
    shares = [
        np.sum((f.r[:, :-1] @ solution.to_beta[i]) ** 2) / s**2
        for f, i, s in zip(factors, indices, solution.sigma, strict=True)
    ]
    return np.array(shares)
