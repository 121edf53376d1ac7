"""The rows of every joint's equation for one layout, piece by piece."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.blocks import Pieces
from pa10d.identify.piece import Piece
from pa10d.model import Term
from pa10d.regression.layout import Layout, has_sign
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]

STEP = 0.05  # in ln v0, for the derivative of the smoothed sign


@dataclass(frozen=True)
class Rows:
    """Consecutive decimated samples: columns[j] (M, k_j), tau (M, n) N·m, keep (M, n) those that
    are fitted, and rest (M, n) those of a resting joint."""

    columns: Sequence[Array]
    tau: Array
    keep: NDArray[np.bool_]
    rest: NDArray[np.bool_]

    def times(self, weights: Array) -> Rows:
        """Every row multiplied by its weight, (M, n)."""
        columns = [c * weights[:, j, None] for j, c in enumerate(self.columns)]
        return Rows(columns, self.tau * weights, self.keep, self.rest)

    def residual(self, indices: Sequence[NDArray[np.int64]], beta: Array) -> Array:
        """(M, n) N·m; each joint's first columns are the unknowns ``indices[j]``."""
        known = [c[:, : len(i)] @ beta[i] for c, i in zip(self.columns, indices, strict=True)]
        return self.tau - np.column_stack(known)


def rows_of(piece: Piece, layout: Layout, bent: NDArray[np.bool_] | None = None) -> Rows:
    """Columns in the order of ``layout.of_joint``; where ``bent[j]``, one more at the end: the
    derivative of joint j's smoothed sign by ln v0."""
    columns = []
    for j in range(layout.robot.n):
        terms = [t for t in layout.terms if t.touches(j)]
        if bent is None or not bent[j]:
            columns.append(np.column_stack([piece.rigid[j], piece.filtered(terms, j)]))
            continue
        sharp, smooth = _bracket(next(t for t in terms if has_sign(t, j)))
        found = piece.filtered([*terms, smooth, sharp], j)
        slope = (found[:, -2] - found[:, -1]) / (2 * STEP)
        columns.append(np.column_stack([piece.rigid[j], found[:, :-2], slope]))
    return Rows(columns, piece.tau, piece.moving, piece.resting)


def all_rows(
    pieces: Pieces, layout: Layout, bent: NDArray[np.bool_] | None = None
) -> Iterator[Rows]:
    """``rows_of`` for one piece after the other."""
    return (rows_of(piece, layout, bent) for piece in pieces)


def triangles_of(
    stretches: Iterable[Rows], rest: bool = False, into: list[Triangle] | None = None
) -> list[Triangle]:
    """Per joint the triangular factor of [columns, torque] over the samples that are fitted, or
    over those at rest; ``into``: factors that take in more rows."""
    found: list[Triangle] = [] if into is None else into
    for rows in stretches:
        chosen = rows.rest if rest else rows.keep
        for j, columns in enumerate(rows.columns):
            if len(found) <= j:
                found.append(Triangle(columns.shape[1] + 1))
            mask = chosen[:, j]
            found[j].add(columns[mask], rows.tau[mask, j])
    return found


def _bracket(term: Term) -> tuple[Term, Term]:
    name = term.effect.smoothed_over
    factors = float(np.exp(-STEP)), float(np.exp(STEP))
    sharp, smooth = (replace(term, shape={name: term.shape[name] * f}) for f in factors)
    return sharp, smooth
