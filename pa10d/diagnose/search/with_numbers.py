"""What is told: changes of which at least one number is an estimate, findings that are needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import MATERIAL_GAIN
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.judging import Place
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.versions import snapshot
from pa10d.effects import Value
from pa10d.judgement import RunResidual
from pa10d.model import Term, TorqueModel
from pa10d.model.estimates import may_be_nothing, no_whole, not_one

Array = NDArray[np.float64]


def only_with_numbers(search: Search, given: TorqueModel, as_given: Sequence[RunResidual]) -> None:
    """Drop what was found and has not one number that the data determine: all that is known of it
    is that columns of such a shape take something, and so does whatever a model lacked before. What
    is larger than it may be is no estimate either, but a larger change is not told less.

    as_given: the held-out side as the given model saw it
    """
    while len((state := search.state).terms) > search.fixed:
        version = _by_its_law(search, given, as_given)
        none = [
            index
            for index in range(search.fixed, len(state.terms))
            if not_one(state.terms[index], values := version.term_values(index))
            and not too_large(state.terms[index], values)
        ]
        if not none:
            return
        for index in reversed(none):
            state.drop(index)
        search.settle()


def needed_without_numbers(
    search: Search, given: TorqueModel, as_given: Sequence[RunResidual]
) -> set[Place]:
    """Drop what has not one number that the data determine where nothing is the worse for it once
    the others are fitted anew: another finding, not yet refined when it came, had left what it
    took. Of a single spring much is fitted at once, and nothing else has left it; but what has no
    number and may as well be nothing is no finding, whatever columns of its shape take. Nor is what
    takes less than is left: as far as anybody knows that is one with what it took. Says which.

    as_given: the held-out side as the given model saw it
    """
    before = _found(search)
    _without_shares(search, given, as_given)
    _without_needless(search, given, as_given)
    return before - _found(search)


def _by_its_law(search: Search, given: TorqueModel, as_given: Sequence[RunResidual]) -> TorqueModel:
    """The model with all that was found, each effect's errors by the law that was found for it: the
    data tell a number also where a law with another exponent would have another one."""
    return snapshot(given, search.state, len(search.state.terms), as_given, of_law=False)


def _found(search: Search) -> set[Place]:
    return {(t.effect_id, t.joints) for t in search.state.terms[search.fixed :]}


def _without_needless(search: Search, given: TorqueModel, as_given: Sequence[RunResidual]) -> None:
    found = search.state.terms[search.fixed :]
    springs = [t for t in found if t.effect.series_spring]
    asked = [t for t in found if not t.effect.series_spring or len(springs) > 1]
    if not asked:
        return
    version = _by_its_law(search, given, as_given)
    for index in reversed(range(search.fixed, len(search.state.terms))):
        term = search.state.terms[index]
        single = term.effect.series_spring and len(springs) < 2
        if single or not not_one(term, version.term_values(index)):
            continue
        saved, before = search.state.copy(), rms(search.state.held_residual())
        search.state.drop(index)
        search.settle()
        without = rms(search.state.held_residual())
        needed = len(found) < 2 or bool(np.any(without > (1.0 + MATERIAL_GAIN) * before))
        if needed and not _less_than_is_left(without, before, search.floor):
            search.state = saved


def _less_than_is_left(without: Array, left: Array, floor: Array | None) -> bool:
    """Is less than half taken of what is above the noise on the joint that it helps most? (n,) N·m
    RMS held out, without something and with it, and of the noise, nan where that is not known."""
    best = int(np.argmax((without**2 - left**2) / without**2))
    if floor is None or not np.isfinite(floor[best]):
        return False
    return bool(left[best] ** 2 - floor[best] ** 2 > without[best] ** 2 - left[best] ** 2)


def _without_shares(search: Search, given: TorqueModel, as_given: Sequence[RunResidual]) -> None:
    """Drop springs and gaps without a number of which the share may as well be zero, or is surely
    none that all of a joint's torque could have: something else asks for columns like theirs."""
    state = search.state
    asked = [
        index
        for index in range(search.fixed, len(state.terms))
        if any(c.whole_at_one for c in state.terms[index].effect.coefficients)
    ]
    if not asked:
        return
    version = _by_its_law(search, given, as_given)
    values = {index: version.term_values(index) for index in asked}
    none = [
        index
        for index, found in values.items()
        if not_one(term := state.terms[index], found)
        and (may_be_nothing(term, found) or no_whole(term, found))
    ]
    for index in reversed(none):
        state.drop(index)
    if none:
        search.settle()


def needed_beside_springs(search: Search) -> None:
    """Drop what later came to be needless beside a spring: until that was refined, what it leaves
    drew the loads, and another finding may have been judged by what it took of that."""
    found = search.state.terms[search.fixed :]
    if any(term.effect.series_spring for term in found) and search.prune():
        search.settle()


def too_large(term: Term, found: Mapping[str, Value]) -> bool:
    """Is one of its sizes beyond the far end of what it may be?"""
    return any(
        c.name in found
        and found[c.name].beyond
        and (found[c.name].value >= c.upper or found[c.name].value <= c.lower < 0.0)
        for c in term.effect.coefficients
    )
