"""What a search has found without the last of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pa10d.diagnose.constants import AS_BEFORE, HOME_ROUNDS
from pa10d.diagnose.regression.partial import partials
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.refitting import look_anew
from pa10d.model import Term


def with_first(state: SearchState, size: int, given: Sequence[Term]) -> SearchState:
    """With the first terms alone. How blunt a sign is beside a later finding is not how blunt it
    would be without: as it was given, where that suits the fit side better."""
    part = state.bare(size, own_weights=True)
    touched = {j for term in state.terms[size:] for j in term.joints}
    for index, came in enumerate(given):
        blunt = bool(came.effect.smoothed_over) and part.terms[index].shape != came.shape
        if blunt and touched & {*came.joints}:
            as_it_came = replace(part.terms[index], shape=came.shape)
            if size == len(given) or _suits(part, index, as_it_came):
                part.replace_term(index, as_it_came)
                part.refit()
    if any(term.effect.uses_model for term in part.terms):
        _with_loads_of_its_own(part)
    return part


def _with_loads_of_its_own(part: SearchState) -> None:
    """Not those of all findings together, with which the smaller model does not go on."""
    left = part.fit.rms()
    for _ in range(HOME_ROUNDS):
        look_anew(part)
        before, left = left, part.fit.rms()
        if np.all(np.abs(left - before) <= AS_BEFORE * before):
            return


def _suits(part: SearchState, index: int, other: Term) -> bool:
    """Does it take more of the fit side's error than the term that is there?"""
    shapes = [part.terms[index].shape, other.shape]
    columns = part.train.columns(other.effect, other.joints, shapes)
    width = len(other.effect.coefficients)
    there, instead = partials(part.fit_without(index), columns, other.effect, width)
    return instead.gain > there.gain
