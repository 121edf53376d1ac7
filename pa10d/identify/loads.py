"""Effects that follow the model's own loads and torques: seen through a first fit.

Load friction needs the load, a saturating drive the torque; both are known once the rest of the
model is. A first fit is enough to begin with, and what all terms together give replaces it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.blocks import Pieces
from pa10d.identify.fit import plain_fit
from pa10d.identify.smoothing import find_smoothing, with_smoothing
from pa10d.model import TorqueModel
from pa10d.regression.layout import Layout, textbook

Array = NDArray[np.float64]

AT_HOME = 12  # rounds in which a law that swings about its answer comes near enough
ROUNDS = 2  # the first takes off what a textbook fit had wrong for want of these terms
OF_A_SPRING = 5  # from one to the next it goes half of the way, so that a thirtieth is left
HALF_OF_THE_WAY = 0.5  # a soft spring overshoots: its share swung between 0.87 and 0.67


def first_model(pieces: Pieces, layout: Layout) -> TorqueModel:
    """What a weighted fit to some of the data says."""
    beta = plain_fit(pieces, layout)
    return TorqueModel(
        name="probe",
        robot=layout.robot,
        base=layout.base,
        h=layout.rigid(beta),
        terms=layout.fitted(beta),
        covariance=np.zeros((0, 0)),
        noise=np.zeros(layout.robot.n),
        cutoff=pieces.cutoff,
    )


def look_through_textbook(pieces: Pieces, layout: Layout) -> None:
    """Before anything is known of the terms that follow the model."""
    if layout.follows_model:
        plain = textbook(layout.robot)
        plain = with_smoothing(plain, find_smoothing(pieces, plain))
        pieces.look_through(first_model(pieces, plain))


def look_through_all(pieces: Pieces, layout: Layout) -> Layout:
    """Shapes, smoothing and timing are found: let loads and torques be those of all terms, and
    secants of nonlinear laws those of their own answer; the layout with them."""
    springs = layout.has_springs
    least, seen = OF_A_SPRING if springs else ROUNDS, None
    for number in range(AT_HOME if layout.follows_model else 0):
        model = first_model(pieces, layout)
        if springs and seen is not None:
            model = _between(seen, model)
        pieces.look_through(model)
        seen = model
        shapes = [t.effect.relinearised(t.coefficients, t.shape) for t in model.terms]
        moved = shapes != [t.shape for t in layout.terms]
        layout = layout.with_shapes(dict(enumerate(shapes)))
        if number + 1 >= least and not moved:
            break
    return layout


def _between(seen: TorqueModel, found: TorqueModel) -> TorqueModel:
    """Bodies and coefficients on the way from the model that loads were seen through to the one
    that was fitted to them."""
    terms = tuple(
        replace(t, coefficients=_part(s.coefficients, t.coefficients))
        for s, t in zip(seen.terms, found.terms, strict=True)
    )
    return replace(found, h=_part(seen.h, found.h), terms=terms)


def _part(before: Array, after: Array) -> Array:
    return before + HALF_OF_THE_WAY * (after - before)
