"""Shapes of further effects that a user asked for: the best of the effect's own starting values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.identify.blocks import Pieces
from pa10d.identify.rows import Rows, triangles_of
from pa10d.model import Term
from pa10d.regression.layout import Layout
from pa10d.regression.triangle import left_over


def with_starting_shapes(layout: Layout, pieces: Pieces) -> Layout:
    """The layout with a shape for every effect that has one and was not given it.

    Judged on the joint's own equation; ``told`` refines them once the timing is known.
    """
    shapes = {
        i: _best(layout, pieces, term)
        for i, term in enumerate(layout.terms)
        if term.effect.shapes and not term.shape
    }
    return layout.with_shapes(shapes) if shapes else layout


def _best(layout: Layout, pieces: Pieces, term: Term) -> dict[str, float]:
    joint = term.joints[0] if term.joints else 0
    first = next(iter(pieces.some()))
    trials = [replace(term, shape=dict(s)) for s in term.effect.starts(first.context, term.joints)]
    if len(trials) == 1:
        return trials[0].shape
    others = [
        t
        for t in layout.terms
        if t is not term and t.touches(joint) and (t.shape or not t.effect.shapes)
    ]

    def rows():
        for piece in pieces.some():
            more = piece.filtered([*others, *trials], joint)
            columns = np.column_stack([piece.rigid[joint], more])
            one = slice(joint, joint + 1)
            yield Rows([columns], piece.tau[:, one], piece.moving[:, one], ~piece.moving[:, one])

    triangle = triangles_of(rows())[0]
    count = len(trials) * term.width
    left = left_over(triangle.r, triangle.width - 1 - count)
    losses = []
    for k in range(len(trials)):
        part = left[:, k * term.width : (k + 1) * term.width]
        solved = np.linalg.lstsq(part, left[:, -1], rcond=1e-9)[0]
        losses.append(float(np.sum((left[:, -1] - part @ solved) ** 2)))
    return trials[int(np.argmin(losses))].shape
