"""A model after a change: refitted, loads and shapes anew until that brings nothing more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    AT_HOME,
    HOME_ROUNDS,
    MATERIAL_GAIN,
    MORE_ROUNDS,
    PART_OF_THE_WAY,
    WORTH_A_ROUND,
)
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.bristles import carried_wholly, give_way, halfway, what_is_left
from pa10d.diagnose.search.refining import only_rounds, refine
from pa10d.diagnose.search.springs import follow
from pa10d.diagnose.search.timing import align
from pa10d.model import Term

Array = NDArray[np.float64]


def settled(state: SearchState, fixed: int, rounds: int = 2) -> SearchState:
    """Refit; loads of the new model; shapes of all nonlinear terms anew; as many more rounds as
    bring something. The best of them counts. Where loads and shapes draw each other on (a gap,
    a spring), one that brings nothing does not end it."""
    state.refit()
    align(state)
    drawn = state.drawn_by_loads
    begun = state.loads
    best, least, idle = state, np.inf, 0
    for number in range(1, rounds + MORE_ROUNDS + 1):
        before = state.terms
        _come_home(state, fixed)
        for index, term in enumerate(state.terms):
            early = number == 1 and only_rounds(term)  # it would imitate what is not settled
            if term.effect.shapes and not early and _worth_refining(state, fixed, index):
                refine(state, fixed, index)
        look_anew(state)
        give_way(state)
        state = halfway(state, before)
        left = what_is_left(state)
        idle = 0 if left < least - WORTH_A_ROUND else idle + 1
        if left < least:
            best, least = state.copy(), left
        if number >= rounds and idle > drawn:
            break
    best, least = carried_wholly(best, least, fixed)
    return with_springs_followed(best, least, begun)


def look_anew(state: SearchState) -> None:
    """Loads of the present coefficients, and refitted; only part of the way to them where all of it
    leaves materially more: what follows the loads draws the bodies along, and those the loads, to
    where neither is what the data ask for. A gap, a spring, bristles get worse before they get
    better."""
    left, old = what_is_left(state) + float(np.log1p(MATERIAL_GAIN)), state.loads
    state.relook()
    state.refit()
    new = state.loads
    if old is None or new is None or what_is_left(state) <= left:
        return
    if state.drawn_by_loads or any(t.effect.builds_up_over for t in state.terms):
        return
    for share in PART_OF_THE_WAY:
        state.look_at(old + share * (new - old))
        state.refit()
        if what_is_left(state) <= left:
            return


def with_springs_followed(best: SearchState, least: float, begun: Array | None) -> SearchState:
    """The same with bodies and springs fitted at once, where that leaves less."""
    if best.frozen or not any(term.effect.series_spring for term in best.terms):
        return best
    found = follow(best, [h for h in (begun, best.loads) if h is not None])
    return best if found is None or what_is_left(found) >= least else found


def _come_home(state: SearchState, fixed: int) -> None:
    """Refitted, with secants of nonlinear laws taken anew until they are those of their answer, as
    far as the data can tell: a step that brings little may still be one of many."""
    for _ in range(HOME_ROUNDS):
        before, moved = state.terms[fixed:], _relinearise(state, fixed)
        look_anew(state)
        if not moved or _unmoved(state, fixed, before):
            return


def _unmoved(state: SearchState, fixed: int, before: Sequence[Term]) -> bool:
    """Are the terms beyond the given ones where they were, to a fraction of what noise does?"""
    noise = np.sqrt(np.maximum(np.diag(state.fit.covariance()), 0.0))
    for index, old in enumerate(before, fixed):
        step = np.abs(state.terms[index].coefficients - old.coefficients)
        if np.any(step > AT_HOME * noise[state.place(index)]):
            return False
    return True


def _relinearise(state: SearchState, fixed: int) -> bool:
    """Columns at the coefficients found; whether any of them has to be taken elsewhere."""
    moved = False
    for index, term in enumerate(state.terms[fixed:], fixed):
        shape = term.effect.relinearised(term.coefficients, term.shape)
        if shape != term.shape:
            state.problem = state.problem.with_term(index, replace(term, shape=shape))
            moved = True
    return moved


def _worth_refining(state: SearchState, fixed: int, index: int) -> bool:
    """Findings; and of the given terms those on joints that a finding can have changed."""
    found = state.terms[fixed:]
    reached = any(t.effect.reaches_other_joints for t in found) and not state.frozen
    if index >= fixed or reached:
        return True
    return state.terms[index].joints[0] in {j for t in found for j in t.joints}
