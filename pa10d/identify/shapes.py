"""Shapes of further effects that a user asked for: the best of the effect's own starting values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.identify.blocks import Pieces
from pa10d.identify.layout import Layout, Slot
from pa10d.identify.rows import Rows, triangles_of
from pa10d.identify.triangle import left_over


def with_starting_shapes(layout: Layout, pieces: Pieces) -> Layout:
    """The layout with a shape for every effect that has one and was not given it.

    Judged on the joint's own equation; refining them is what adding an effect to a model does.
    """
    shapes = {
        i: _best(layout, pieces, slot)
        for i, slot in enumerate(layout.slots)
        if slot.effect.shapes and not slot.shape
    }
    return layout.with_shapes(shapes) if shapes else layout


def _best(layout: Layout, pieces: Pieces, slot: Slot) -> dict[str, float]:
    joint = slot.joints[0] if slot.joints else 0
    first = next(iter(pieces.some()))
    trials = [replace(slot, shape=dict(s)) for s in slot.effect.starts(first.context, slot.joints)]
    if len(trials) == 1:
        return trials[0].shape
    others = [
        s
        for s in layout.slots
        if s is not slot and s.touches(joint) and (s.shape or not s.effect.shapes)
    ]

    def rows():
        for piece in pieces.some():
            more = piece.filtered([*others, *trials], joint)
            columns = np.column_stack([piece.rigid[joint], more])
            one = slice(joint, joint + 1)
            yield Rows([columns], piece.tau[:, one], piece.moving[:, one], ~piece.moving[:, one])

    triangle = triangles_of(rows())[0]
    count = len(trials) * slot.width
    left = left_over(triangle.r, triangle.width - 1 - count)
    losses = []
    for k in range(len(trials)):
        part = left[:, k * slot.width : (k + 1) * slot.width]
        solved = np.linalg.lstsq(part, left[:, -1], rcond=1e-9)[0]
        losses.append(float(np.sum((left[:, -1] - part @ solved) ** 2)))
    return trials[int(np.argmin(losses))].shape
