"""The shape of one term that fits best beside all else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import CLOSER_STEPS, LEAST_GAIN
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.partial import PartialFit, partials
from pa10d.diagnose.regression.shapes import approach, around, free_shapes
from pa10d.diagnose.regression.shapes import refine as refined
from pa10d.diagnose.regression.slopes import newton_move
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.turning import drop_at_reversals
from pa10d.model import Term
from pa10d.regression.layout import has_sign

Array = NDArray[np.float64]


def refine(state: SearchState, fixed: int, index: int) -> None:
    """The shape of one term that fits best beside all else."""
    term = state.terms[index]
    if index >= fixed and state.same_before(term.effect, term.joints) is not None:
        return
    rest = state.fit_without(index)
    width = len(term.effect.coefficients)
    falls = index >= fixed and state.may_fall(term.effect)

    train = state.train
    heeded = (term.effect_id, term.joints) in state.heeding
    at_reversals = drop_at_reversals(state, rest, term) if heeded else None

    def fitted(shape: dict[str, float]) -> PartialFit:
        columns = train.columns(term.effect, term.joints, [shape])
        return partials(rest, columns, term.effect, width, falls=falls)[0]

    def gain(shape: dict[str, float]) -> float:
        found = fitted(shape)
        return found.gain + (0.0 if at_reversals is None else at_reversals(shape, found))

    def move(shape: dict[str, float]) -> Array:
        there = replace(term, shape=shape, coefficients=fitted(shape).theta)
        return newton_move(train, rest, there)

    far = False
    if any(s.blur for s in free_shapes(term.effect, term.shape)):  # knocks: rough everywhere
        shape = _closer(state, index, rest, falls)
    elif term.effect.reaches_other_joints:  # links thrown about, and dear to compute
        shape = refined(term.effect, term.shape, gain, evaluations=10)
    elif heeded:
        shape = refined(term.effect, term.shape, gain)
    else:
        shape = approach(term.effect, term.shape, gain, move)
    if only_rounds(term) and gain(shape) < gain(dict(term.shape)) + LEAST_GAIN:
        away = _far_away(state, index, rest, falls)
        if away is None:
            return  # how sharp a corner is shows only on what passes it slowly: no guessing
        shape, far = approach(term.effect, away, gain, move), True
    plain = _turning_as_dry_friction(state, term, shape)
    if plain is not None and gain(shape) < gain(plain) + LEAST_GAIN:
        shape = plain
    if shape != term.shape:
        before = rms(state.held_residual()) if far else None
        state.replace_term(index, replace(term, shape=shape))
        state.refit()
        if before is not None and np.any((rms(state.held_residual()) > before)[[*term.joints]]):
            state.replace_term(index, term)  # so far away the fit side alone is not believed
            state.refit()


def _far_away(
    state: SearchState, index: int, rest: LeastSquares, falls: bool
) -> dict[str, float] | None:
    """Of the effect's own starts the best, where no shape near the one that is there is told from
    it: what passes a corner faster than it is wide does not say which way the best one lies."""
    term, train = state.terms[index], state.train
    here, width = dict(term.shape), len(term.effect.coefficients)
    free = {s.name for s in free_shapes(term.effect, here)}
    if not free:
        return None

    def gains(shapes: list[dict[str, float]]) -> list[float]:
        columns = train.columns(term.effect, term.joints, shapes)
        return [p.gain for p in partials(rest, columns, term.effect, width, falls=falls)]

    near = gains([here, *around(term.effect, here)[::4]])
    if max(near) > min(near) + LEAST_GAIN:
        return None
    starts = [
        here | {name: value for name, value in start.items() if name in free}
        for start in term.effect.starts(train.contexts[0], term.joints)
    ]
    far = gains(starts)
    return starts[int(np.argmax(far))] if max(far) > max(near) + LEAST_GAIN else None


def _turning_as_dry_friction(
    state: SearchState, term: Term, shape: dict[str, float]
) -> dict[str, float] | None:
    """All that rubs in a joint turns round with it: over the speed over which its Coulomb friction
    does, unless the data show another. None: there is none, or the shape has no such corner."""
    dry = [t for t in state.terms if len(term.joints) == 1 and has_sign(t, term.joints[0])]
    corners = [s for s in free_shapes(term.effect, shape) if s.smoothing]
    if not dry or term in dry or not corners:
        return None
    speed = dry[0].shape[dry[0].effect.smoothed_over]
    return shape | {s.name: max(s.lower, speed) for s in corners}


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
