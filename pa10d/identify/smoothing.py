"""The speed v0 over which each joint's Coulomb sign is smoothed, found from the data.

Wrong by a factor of two it leaves several times the noise at every reversal. For each joint the
squared error of its own equation, all other unknowns of that equation fitted, is followed over a
logarithmic grid of v0. Where the model lacks more than noise, its residual is correlated over
many samples and a few reversals prove little: between the best v0 and the usual one the value
nearest to the usual is taken that is not clearly worse, correlated samples counting as one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.blocks import Pieces
from pa10d.identify.jackknife import moved_by_stretches, without_each
from pa10d.identify.piece import Piece
from pa10d.identify.rows import Rows, triangles_of
from pa10d.model import Term
from pa10d.regression.layout import START_V0, Layout, has_sign
from pa10d.regression.spectrum import colour
from pa10d.regression.triangle import Triangle, left_over, min_norm

Array = NDArray[np.float64]

COARSE = START_V0 * np.geomspace(0.05, 20.0, 11)
USUAL = int(np.argmin(np.abs(np.log(COARSE / START_V0))))
FINE = np.array([0.5, 0.7, 0.85, 1.0, 1.18, 1.43, 2.0])  # around the best of them
FINEST = np.array([0.96, 1.0, 1.04])
BLUNTER, SHARPER = 16.0, 6.0  # drop of the squared error, in units of one independent sample, that
# proves a v0 above or below the usual one: a blunt sign imitates other effects, a sharp one nothing
FAR_BETTER = 2.0  # times: a curve gains less by a sign that is smoothed over more
WIDEST = 0.03  # of the fast speed: a sign smoothed over more is no Coulomb friction but a curve


@dataclass(frozen=True)
class Smoothing:
    """v0 (n,) rad/s; found (n,) False where the data cannot tell it from the usual value (few
    reversals, little friction); errors (n,) rad/s: standard errors, by how fast the squared error
    rises around the best, and from stretch to stretch."""

    v0: Array
    found: NDArray[np.bool_]
    errors: Array


def find_smoothing(pieces: Pieces, layout: Layout) -> Smoothing:
    """v0 of every joint's dry friction."""
    n = layout.robot.n
    grids = [COARSE] * n
    fits = _fits(pieces, layout, grids)
    losses = [_loss(f, len(COARSE)) for f in fits]
    unit = _unit_of_evidence(pieces, layout, fits, losses)
    widest = np.clip(WIDEST * pieces.fast, COARSE[0], COARSE[-1])
    chosen = [
        _nearest_as_good(loss / u, int(np.searchsorted(COARSE, w, side="right")))
        for loss, u, w in zip(losses, unit, widest, strict=True)
    ]
    found = np.array(
        [loss.max() - loss.min() > BLUNTER * u for loss, u in zip(losses, unit, strict=True)]
    )
    best = np.array([COARSE[k] for k in chosen])
    at_optimum = [_is_lowest(loss, k) for k, loss in zip(chosen, losses, strict=True)]
    beyond = [_lies_beyond(loss, k, w) for k, loss, w in zip(chosen, losses, widest, strict=True)]
    best = np.where(beyond, widest, best)
    spread = np.full(n, np.inf)
    for factors in (FINE, FINEST):
        grids = [
            np.unique(np.clip(b * factors, COARSE[0], w)) if fine else np.array([b])
            for b, w, fine in zip(best, widest, np.logical_or(beyond, at_optimum), strict=True)
        ]
        rows = list(_trial_rows(pieces, layout, grids))
        losses = _losses(triangles_of(rows), grids)
        if factors is FINE:
            spread = np.array([_spread(*of) for of in zip(grids, losses, unit, strict=True)])
            spread = np.hypot(spread, _from_stretch_to_stretch(rows, grids))
        best = _best(grids, losses)
    pieces.forget_columns()
    v0 = np.where(found, best, START_V0)
    return Smoothing(v0, found, np.where(found, v0 * spread, np.inf))


def _losses(fits: Sequence[Triangle], grids: Sequence[Array]) -> list[Array]:
    return [_loss(f, len(g)) for f, g in zip(fits, grids, strict=True)]


def _best(grids: Sequence[Array], losses: Sequence[Array]) -> Array:
    return np.array([_minimum(g, loss) for g, loss in zip(grids, losses, strict=True)])


def _from_stretch_to_stretch(rows: Sequence[Rows], grids: Sequence[Array]) -> Array:
    """(n,) standard error of ln v0 by how far it depends on which reversals are looked at: a joint
    that goes through its corner within a sample tells it by where in that it turned round, which
    no noise of its torque knows of."""
    without = without_each(rows, lambda fits: np.log(_best(grids, _losses(fits, grids))))
    return np.array([moved_by_stretches(of_joint) for of_joint in without.T])


def sharp_where_unseen(smoothing: Smoothing, faster_than: Array | None) -> Smoothing:
    """Where every fitted sample is faster than v0 they cannot tell it: the sign itself is taken."""
    if faster_than is None:
        return smoothing
    unseen = faster_than > smoothing.v0
    return Smoothing(
        np.where(unseen, COARSE[0], smoothing.v0),
        smoothing.found & ~unseen,
        np.where(unseen, np.inf, smoothing.errors),
    )


def with_smoothing(layout: Layout, smoothing: Smoothing) -> Layout:
    """The layout with these v0 in the joints' dry friction."""
    shapes = {
        i: {t.effect.smoothed_over: float(smoothing.v0[t.joints[0]])}
        for i, t in enumerate(layout.terms)
        if t.effect.smoothed_over
    }
    return layout.with_shapes(shapes)


def _trial_rows(pieces: Pieces, layout: Layout, grids: Sequence[Array]) -> Iterator[Rows]:
    """Rows with, per joint, all other columns first and then one Coulomb column per v0."""
    n = layout.robot.n
    others = [[t for t in layout.terms if t.touches(j) and not has_sign(t, j)] for j in range(n)]
    own = [next(t for t in layout.terms if has_sign(t, j)) for j in range(n)]
    trials = [
        [replace(t, shape={t.effect.smoothed_over: float(v)}) for v in grid]
        for t, grid in zip(own, grids, strict=True)
    ]

    def columns(piece: Piece, joint: int, terms: Sequence[Term]) -> Array:
        return np.column_stack([piece.rigid[joint], piece.filtered(terms, joint)])

    for piece in pieces.some():
        found = [columns(piece, j, others[j] + trials[j]) for j in range(n)]
        yield Rows(found, piece.tau, piece.moving, ~piece.moving)


def _fits(pieces: Pieces, layout: Layout, grids: Sequence[Array]) -> list[Triangle]:
    """Per joint: the factor of [all other columns, one column per v0, torque]."""
    return triangles_of(_trial_rows(pieces, layout, grids))


def _unit_of_evidence(
    pieces: Pieces, layout: Layout, fits: Sequence[Triangle], losses: Sequence[Array]
) -> Array:
    """(n,) squared error that one independent sample has on average at the best v0."""
    best = [int(np.argmin(loss)) for loss in losses]
    beta = []
    for k, fit in zip(best, fits, strict=True):
        given = fit.width - 1 - len(COARSE)
        known = np.delete(fit.r, np.s_[given:-1], axis=1)
        beta.append(min_norm(known, fit.r[:, given + k]))
    stretches: list[list[tuple[Array, NDArray[np.bool_]]]] = [[] for _ in best]
    for part in _trial_rows(pieces, layout, [COARSE[k : k + 1] for k in best]):
        for j, solved in enumerate(beta):
            error = part.tau[:, j] - part.columns[j] @ solved
            stretches[j].append((error, part.keep[:, j]))
    out = np.empty(len(best))
    for j, k in enumerate(best):
        gamma = colour(stretches[j], pieces.rate)
        inflation = 1.0 + 2.0 * float(gamma[1:].sum()) / max(float(gamma[0]), 1e-300)
        torque = float(losses[j].max())
        noise = max(float(losses[j][k]), 1e-20 * torque) / max(fits[j].rows, 1)
        out[j] = max(inflation, 1.0) * max(noise, 1e-300)
    return out


def _nearest_as_good(loss: Array, count: int) -> int:
    """Index, among the first ``count`` of the coarse grid, of the v0 nearest to the usual one that
    is not clearly worse than the best of them."""
    best = int(np.argmin(loss[:count]))
    usual = min(USUAL, count - 1)
    step, clear = (1, BLUNTER) if best >= usual else (-1, SHARPER)
    for k in range(usual, best, step):
        if loss[k] - loss[best] < clear:
            return k
    return best


def _is_lowest(loss: Array, k: int) -> bool:
    """Whether no neighbour on the grid is better, so that a finer search around k makes sense."""
    return bool(loss[k] <= loss[max(0, k - 1) : k + 2].min())


def _lies_beyond(loss: Array, k: int, widest: float) -> bool:
    """Whether the sign asks for more than the last of the coarse grid below the widest v0."""
    after = k + 1
    return after < len(loss) and COARSE[after] > widest and loss[k] > FAR_BETTER * loss[after]


def _loss(fit: Triangle, count: int) -> Array:
    """(grid,) squared error for each of ``count`` v0."""
    left = left_over(fit.r, fit.width - 1 - count)
    columns, torque = left[:, :-1], left[:, -1]
    power = np.maximum(np.sum(columns**2, axis=0), 1e-300)
    return np.asarray(float(torque @ torque) - (columns.T @ torque) ** 2 / power)


def _minimum(grid: Array, loss: Array) -> float:
    """v0 at the vertex of the parabola through the best grid value and its neighbours."""
    x, curve = _around(grid, loss)
    at = float(np.clip(-0.5 * curve[1] / curve[0], x[0], x[-1])) if curve[0] > 0 else 0.0
    return float(grid[int(np.argmin(loss))] * np.exp(at))


def _spread(grid: Array, loss: Array, unit: float) -> float:
    """Standard error of ln v0: as far from the best the squared error has risen by one unit."""
    _, curve = _around(grid, loss)
    return float(np.sqrt(unit / curve[0])) if curve[0] > 0 else float(np.inf)


def _around(grid: Array, loss: Array) -> tuple[Array, Array]:
    """ln v0 about the best grid value at it and its neighbours, and the parabola through them."""
    k = int(np.argmin(loss))
    if not 0 < k < len(grid) - 1:
        return np.zeros(1), np.zeros(3)
    x = np.log(grid[k - 1 : k + 2] / grid[k])
    return x, np.polyfit(x, loss[k - 1 : k + 2] - loss[k], 2)
