"""Held-out error that lies where the fit side has never been: no fit could have known of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import MOSTLY_BEYOND
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.effects import Context

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Beyond:
    """share: of a joint's squared error on the held-out side, where the variable (``q1``, ``dq2``)
    is above (or below) edge, in unit, which it never is on the fit side; time: share of the
    held-out samples."""

    joint: int
    variable: str
    unit: str
    above: bool
    edge: float
    share: float
    time: float

    @property
    def place(self) -> str:
        """In words."""
        side = "above" if self.above else "below"
        return f"{self.variable} is {side} {self.edge:.3g} {self.unit}"


def beyond(state: SearchState) -> list[Beyond | None]:
    """Per joint the place, by its own angle or speed, that holds most of its error for the time
    that is spent there. None where the fit side has been where the error is. Of the many quantities
    of other joints one lies beyond by accident."""
    n = state.train.n
    residual = state.held_residual()

    def worst(joint: int) -> Beyond | None:
        places: list[Beyond] = []
        unit = state.model.robot.angle_unit(joint)
        names = ((f"q{joint + 1}", unit), (f"dq{joint + 1}", f"{unit}/s"))
        fitted, held = _own_motion(state.train, joint), _own_motion(state.held, joint)
        for (name, unit), known, asked in zip(names, fitted, held, strict=True):
            places += places_of(joint, name, unit, known, asked, residual[joint])
        return max(places, key=lambda place: place.share - place.time, default=None)

    return [worst(j) for j in range(n)]


def _own_motion(side: Side, joint: int) -> tuple[Array, Array]:
    """(m_j,) each: a joint's angle and speed in the rows of its equation."""

    def rows(of: Callable[[Context], Array]) -> Array:
        seen = [of(run.context)[:: run.lowpass.factor, joint] for run in side.runs]
        return side.gathered(seen, joint)

    return rows(lambda context: context.q), rows(lambda context: context.dq)


def places_of(
    joint: int, name: str, unit: str, fitted: Array, held: Array, residual: Array
) -> list[Beyond]:
    """Beyond either end of what a quantity was on the fit side, where most of the error lies:
    noise leaves as much of itself there as time is spent there.

    fitted (m,), held (k,): the quantity on both sides; residual (k,) N·m of the held-out one.
    """
    power, out = residual**2, []
    if not power.any():
        return []
    for above, edge in ((True, float(fitted.max())), (False, float(fitted.min()))):
        there = held > edge if above else held < edge
        share, time = float(power[there].sum() / power.sum()), float(there.mean())
        if time < 1.0 and (share - time) / (1.0 - time) > MOSTLY_BEYOND:
            out.append(Beyond(joint, name, unit, above, edge, share, time))
    return out
