"""A model after a change: refitted, loads and shapes anew until that brings nothing more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import CLOSER_STEPS, LEAST_GAIN, MORE_ROUNDS, WORTH_A_ROUND
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.partial import PartialFit, partials
from pa10d.diagnose.regression.shapes import approach, around, free_shapes
from pa10d.diagnose.regression.shapes import refine as refined
from pa10d.diagnose.regression.slopes import newton_move
from pa10d.diagnose.regression.state import SearchState
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
        _relinearise(state, fixed)
        state.relook()
        state.refit()
        for index, term in enumerate(state.terms):
            early = number == 1 and only_rounds(term)  # it would imitate what is not settled
            if term.effect.shapes and not early and _worth_refining(state, fixed, index):
                refine(state, fixed, index)
        state.relook()
        state.refit()
        left = float(np.sum(np.log(state.fit.rms())))
        idle = 0 if left < least - WORTH_A_ROUND else idle + 1
        if left < least:
            best, least = state.copy(), left
        if number >= rounds and idle > drawn:
            break
    return _with_springs_followed(best, least, begun)


def refine(state: SearchState, fixed: int, index: int) -> None:
    """The shape of one term that fits best beside all else."""
    term = state.terms[index]
    rest = state.fit.without(state.place(index))
    width = len(term.effect.coefficients)
    falls = index >= fixed and state.may_fall(term.effect)

    train = state.train

    def fitted(shape: dict[str, float]) -> PartialFit:
        columns = train.columns(term.effect, term.joints, [shape])
        return partials(rest, columns, term.effect, width, falls=falls)[0]

    def gain(shape: dict[str, float]) -> float:
        return fitted(shape).gain

    def move(shape: dict[str, float]) -> Array:
        there = replace(term, shape=shape, coefficients=fitted(shape).theta)
        return newton_move(train, rest, there)

    if any(s.blur for s in free_shapes(term.effect, term.shape)):  # knocks: rough everywhere
        shape = _closer(state, index, rest, falls)
    elif term.effect.reaches_other_joints:  # links thrown about, and dear to compute
        shape = refined(term.effect, term.shape, gain, evaluations=10)
    else:
        shape = approach(term.effect, term.shape, gain, move)
    if only_rounds(term) and gain(shape) < gain(dict(term.shape)) + LEAST_GAIN:
        return  # how sharp a corner is shows only on what passes it slowly: no guessing
    if shape != term.shape:
        state.replace_term(index, replace(term, shape=shape))
        state.refit()


def _with_springs_followed(best: SearchState, least: float, begun: Array | None) -> SearchState:
    """The same with bodies and springs fitted at once, where that leaves less."""
    for index, term in enumerate(best.terms):
        if not term.effect.series_spring or best.frozen:
            continue
        bodies = [h for h in (begun, best.loads) if h is not None]
        found = follow(best, index, bodies)
        left = np.inf if found is None else float(np.sum(np.log(found.fit.rms())))
        if found is not None and left < least:
            best, least = found, left
    return best


def _relinearise(state: SearchState, fixed: int) -> None:
    for index, term in enumerate(state.terms[fixed:], fixed):
        shape = term.effect.relinearised(term.coefficients, term.shape)
        if shape != term.shape:
            state.problem = state.problem.with_term(index, replace(term, shape=shape))


def _worth_refining(state: SearchState, fixed: int, index: int) -> bool:
    """Findings; and of the given terms those on joints that a finding can have changed."""
    found = state.terms[fixed:]
    reached = any(t.effect.reaches_other_joints for t in found) and not state.frozen
    if index >= fixed or reached:
        return True
    return state.terms[index].joints[0] in {j for t in found for j in t.joints}


def _closer(state: SearchState, index: int, rest: LeastSquares, falls: bool) -> dict[str, float]:
    """The best of the shapes around a rough one, then of those closer around that."""
    term, train = state.terms[index], state.train
    best, most = dict(term.shape), -np.inf
    for part in CLOSER_STEPS:
        shapes = around(term.effect, best, part)
        columns = train.columns(term.effect, term.joints, shapes)
        width = len(term.effect.coefficients)
        found = partials(rest, columns, term.effect, width, falls=falls)
        gains = [p.gain for p in found]
        if max(gains) > most:
            best, most = shapes[int(np.argmax(gains))], max(gains)
    return best


def only_rounds(term: Term) -> bool:
    """Whether all that is free of a term's shape is how sharp a corner is."""
    return all(s.smoothing for s in free_shapes(term.effect, term.shape))
