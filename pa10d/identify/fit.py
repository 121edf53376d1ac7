"""Weighted least squares of a whole layout, with honest errors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.blocks import Pieces
from pa10d.identify.rows import Rows, all_rows, rows_of, triangles_of
from pa10d.identify.smoothing import Smoothing
from pa10d.regression.covariance import Uncertainty, WeightedStretch, uncertainty
from pa10d.regression.lacking import Stretch
from pa10d.regression.layout import Layout
from pa10d.regression.problem import LinearProblem
from pa10d.regression.solution import Indices, Solution, Streamed, estimate_weights, solve
from pa10d.regression.told import added_ones, left_open
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]


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


def trust(pieces: Pieces, layout: Layout) -> Array:
    """(n,) N·m by which each joint is weighted: what an even selection of the data leaves of it, at
    rest and in motion."""
    moving, rest = _triangles(rows_of(piece, layout) for piece in pieces.some())
    return estimate_weights(moving, rest, layout.of_joint, layout.size)


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
    uncertain = uncertainty(
        motion,
        lambda: (_seen(rows, outer, wide) for rows in stretches(smoothing.found)),
        [inverse[:, index] for index in outer],
        wide.sigma,
        _leverage(moving, outer, wide),
        pieces.lowpass,
        None if known is None else inverse @ known.scatter(len(inverse)) @ inverse,
    )
    rms = rms_of(plain, inner, solution.beta)
    torque = rms_of(plain, inner, np.zeros(size))
    stated = uncertain.first(size)
    sizes = np.sqrt(np.maximum(np.diag(stated.covariance), 0.0))
    added = added_ones(len(layout.base), layout.terms)
    open_ = left_open(solution.beta, sizes, peaks, torque, rms, added)
    open_[solution.open] = True
    return Fit(solution, stated, rms, torque, plain, open_)


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
