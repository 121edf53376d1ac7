"""Equations without the moments in which what joints have in common sticks.

A joint's own standstills are out of its equation (``pa10d/regression/rests.py``). What two joints
share, a belt or a differential, stands at other moments: both move, and their speeds cancel. Its
friction is then anything between both breakaways, and no column can say which.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.model import Term
from pa10d.regression.equation import CLEAR, RunEquation
from pa10d.regression.rests import FEWEST_MOVING, counted, going

Array = NDArray[np.float64]


def where_shared_slips(equation: RunEquation, terms: Iterable[Term]) -> RunEquation:
    """The equation of every joint that shares a term's surfaces multiplied by 0 where these stand.

    What is left out already stays so: asked again, nothing changes. A joint that would keep hardly
    anything is left as it is.
    """
    shared = list(_shared(equation, terms))
    if not shared:
        return equation
    before = np.ones_like(equation.context.dq) if equation.going is None else equation.going
    share = before.copy()
    for joints, speed in shared:
        slipping = going(speed[:, None], equation.lowpass)
        share[:, joints] = np.minimum(share[:, joints], slipping)
    if np.array_equal(share, before):
        return equation
    keep = equation.keep & counted(share, equation.lowpass, CLEAR)
    alone = keep.sum(axis=0) < FEWEST_MOVING
    return replace(
        equation,
        going=np.where(alone, before, share),
        keep=np.where(alone, equation.keep, keep),
    )


def sharing(equation: RunEquation, terms: Iterable[Term]) -> tuple[int, ...]:
    """Joints (0-based) that share any of the terms' surfaces."""
    return tuple(sorted({j for joints, _ in _shared(equation, terms) for j in joints}))


def _shared(equation: RunEquation, terms: Iterable[Term]) -> Iterator[tuple[list[int], Array]]:
    """Joints and (N,) rad/s at which what they share slips."""
    for term in terms:
        speed = term.effect.slips(equation.context, term.joints, term.shape)
        if speed is not None:
            yield [*term.joints], speed
