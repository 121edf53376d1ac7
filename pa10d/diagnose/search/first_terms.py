"""What a search has found without the last of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pa10d.diagnose.constants import AS_BEFORE, HOME_ROUNDS
from pa10d.diagnose.regression.partial import partials
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.bristles import what_is_left
from pa10d.diagnose.search.refitting import look_anew, with_springs_followed
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
        return _with_loads_of_its_own(part)
    return part


def _with_loads_of_its_own(part: SearchState) -> SearchState:
    """Not those of all findings together, with which the smaller model does not go on. The best of
    some rounds, springs refined: loads that a spring throws about may lead to ever worse ones, and
    what that loses is not what a later finding brings."""
    left, begun = part.fit.rms(), part.loads
    best, least = part.copy(), what_is_left(part)
    for _ in range(HOME_ROUNDS):
        look_anew(part)
        before, left = left, part.fit.rms()
        if what_is_left(part) < least:
            best, least = part.copy(), what_is_left(part)
        if np.all(np.abs(left - before) <= AS_BEFORE * before):
            break
    return with_springs_followed(best, least, begun)


def _suits(part: SearchState, index: int, other: Term) -> bool:
    """Does it take more of the fit side's error than the term that is there?"""
    shapes = [part.terms[index].shape, other.shape]
    columns = part.train.columns(other.effect, other.joints, shapes)
    width = len(other.effect.coefficients)
    there, instead = partials(part.fit_without(index), columns, other.effect, width)
    return instead.gain > there.gain
