"""Friction that a joint's bristles carry: all of it, or does a part there turn round at once?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pa10d.diagnose.constants import BRISTLE_ROUNDS, WORTH_A_ROUND
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.refining import refine
from pa10d.model import Term


def give_way(state: SearchState) -> None:
    """Dry friction that would drive its joint beside bristles is none: they carry all of it."""
    driving = [i for i in _beside_bristles(state) if state.terms[i].coefficients[0] < 0.0]
    for index in driving:
        _move_elsewhere(state, index)
    if driving:
        state.refit()


def carried_wholly(best: SearchState, least: float, fixed: int) -> tuple[SearchState, float]:
    """The same with all dry friction of a joint on its bristles, where that leaves no more: a part
    that turns round at once stands in for bristles that are not yet where they belong."""
    for dry in _beside_bristles(best):
        trial = best.copy()
        _move_elsewhere(trial, dry)
        trial.refit()
        own = [
            i
            for i, t in enumerate(trial.terms)
            if i >= fixed and t.effect.carried and t.joints == trial.terms[dry].joints
        ]
        for _ in range(BRISTLE_ROUNDS):
            before = trial.terms
            for index in own:
                refine(trial, fixed, index)
            trial.relook()
            trial.refit()
            trial = halfway(trial, before)
        left = what_is_left(trial)
        if left < least + WORTH_A_ROUND:
            best, least = trial, left
    return best, least


def _beside_bristles(state: SearchState) -> list[int]:
    """Terms of dry friction on joints that have bristles, too."""
    carried = {t.joints for t in state.terms if t.effect.builds_up_over}
    return [
        i
        for i, t in enumerate(state.terms)
        if t.effect.smoothed_over
        and t.joints in carried
        and "elsewhere" not in t.shape
        and not state.frozen
    ]


def _move_elsewhere(state: SearchState, index: int) -> None:
    term = state.terms[index]
    state.replace_term(index, replace(term, shape={**term.shape, "elsewhere": 1.0}))


def halfway(state: SearchState, before: Sequence[Term]) -> SearchState:
    """The same with the shapes of what bristles carry halfway back to where they were a round ago,
    if that leaves less: how far bristles bend depends on all that they carry, and each shape that
    follows the others' last ones goes too far in turn."""
    on_bristles = {t.joints for t in state.terms if t.effect.builds_up_over}
    trial = state.copy()
    moved = False
    for index, (now, then) in enumerate(zip(state.terms, before, strict=True)):
        if not now.effect.carried or now.joints not in on_bristles or now.shape == then.shape:
            continue
        middle = {name: 0.5 * (value + then.shape[name]) for name, value in now.shape.items()}
        trial.replace_term(index, replace(now, shape=middle))
        moved = True
    if not moved:
        return state
    trial.relook()
    trial.refit()
    return trial if what_is_left(trial) < what_is_left(state) else state


def what_is_left(state: SearchState) -> float:
    """Logarithms of the joints' errors on the fit side, summed."""
    return float(np.sum(np.log(state.fit.rms())))
