"""A model that looks at what the torque does clear of knocks.

When the teeth of a gap meet depends on more digits than anybody knows, and how hard they are is
taken from physics. What a knock is off by passes for smoothness: a prediction that comes too early
or too late is nearer to the torque the softer it is. So the torque channel is asked for where no
shape that the columns blur has a say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import BLURRED_LEAST, BLURRED_ROUNDS
from pa10d.diagnose.regression.shapes import free_shapes
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.slopes import with_slopes
from pa10d.diagnose.regression.state import SearchState
from pa10d.model import Term
from pa10d.regression.per_joint import Mask

Array = NDArray[np.float64]
Clear = tuple[list[Mask], list[Mask]]
"""(M, n) per run of the fit side and of the held-out one: True clear of knocks."""


def clear_of_knocks(*states: SearchState) -> tuple[SearchState, ...]:
    """Each refitted to the samples in which no blurred shape of the last of them leaves open more
    than a small part of what is left of that joint clear of knocks; as they are where it has none.
    """
    clear = clear_samples(states[-1])
    return states if clear is None else tuple(state.where(clear) for state in states)


def blurred(state: SearchState, index: int) -> bool:
    """Do the columns of that term blur its shape?"""
    return bool(_blur(state.terms[index]).any())


def clear_samples(state: SearchState) -> Clear | None:
    """Which those are; None where no term has a blurred shape."""
    terms = [term for index, term in enumerate(state.terms) if blurred(state, index)]
    if not terms:
        return None
    open_ = [_left_open(side, terms) for side in (state.train, state.held)]
    left = state.fit.rms()
    for _ in range(BLURRED_ROUNDS):  # what is left is less, once knocks are out of it
        train, held = ([one <= BLURRED_LEAST * left for one in side] for side in open_)
        left = state.where((train, held)).fit.rms()
    return train, held


def _left_open(side: Side, terms: Sequence[Term]) -> list[Array]:
    """Per run (M, n) N·m that the torque may as well be off by, as wide as the columns blur."""
    runs = tuple(replace(run, keep=np.ones_like(run.keep)) for run in side.runs)
    whole = replace(side, runs=runs, silent={}, kept_by_evidence={})
    squares = [np.zeros(run.tau.shape) for run in runs]
    for term in terms:
        slopes = with_slopes(whole, term).items()
        off = {j: c[:, len(term.coefficients) :] * _blur(term) for j, c in slopes}
        moved = {j: np.sqrt(np.sum(o**2, axis=1)) for j, o in off.items()}
        for total, own in zip(squares, whole.scatter(moved), strict=True):
            total += own**2
    return [np.sqrt(total) for total in squares]


def _blur(term: Term) -> Array:
    """(s,) of each free shape, in its unit."""
    shapes = free_shapes(term.effect, term.shape)
    return np.array([s.blur * abs(term.shape[s.name]) for s in shapes])
