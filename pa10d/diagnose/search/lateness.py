"""A torque that is late, and all that it is late of, fitted at once.

A delay's column is taken of the torque that the model had before, so a fit goes to both by turns.
Late friction is less of a rotor: along that the data hardly tell the two apart, and each turn goes
a small part of a long way. So what is left is sought over the delay itself, all else fitted to it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.optimize

from pa10d.diagnose.constants import LATE_CLOSER, LATE_LOOKS, LATE_ROUNDS
from pa10d.diagnose.regression.state import SearchState


def with_delays_followed(state: SearchState, fixed: int) -> SearchState:
    """The same with each delay that was found where it leaves least; fixed: terms that the model
    was given. A fit with the delay free leaves less, but of a torque that is late by another one.
    """
    for index in range(fixed, len(state.terms)):
        if state.terms[index].effect.forgets_within:
            state = _followed(state, index)
    return state


def _followed(state: SearchState, index: int) -> SearchState:
    term = state.terms[index]
    now = max(float(term.coefficients[0]), float(term.shape.get("at", 0.0)))
    if now <= 0.0:
        return state

    def left(log: float) -> float:
        return _squares(_at(state, index, float(np.exp(log))))

    first = min(np.log(now * LATE_LOOKS), key=left)
    step = np.log(LATE_LOOKS[1] / LATE_LOOKS[0])
    best = scipy.optimize.minimize_scalar(
        left,
        bounds=(first - step, first + step),
        method="bounded",
        options={"maxiter": LATE_CLOSER},
    )
    out = _at(state, index, float(np.exp(best.x)))
    out.weigh(state.problem.sigma)
    out.refit()
    return out


def _at(state: SearchState, index: int, late: float) -> SearchState:
    """A copy so late, all else fitted to that, by the same weights."""
    out, term = state.copy(), state.terms[index]
    out.replace_term(index, replace(term, shape={**term.shape, "at": late}))
    out.weigh(state.fit.sigma)
    for _ in range(LATE_ROUNDS):
        out.refit()
        out.fit = out.fit.with_value(out.place(index).start, late)
        out.look_through(out.fit.beta)
    return out


def _squares(state: SearchState) -> float:
    return sum(float(r @ r) for r in state.fit.residual.values())
