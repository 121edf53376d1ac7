"""A search with friction and rotor inertia of no less than none.

What short runs hardly show of a joint, a free fit gives any value, and to motion that it has not
seen that value is an error larger than most effects: what is missing hides behind it. And what is
missing draws such values: what a servo answers to cogging, say, runs against the speed that the
cogging makes, and is fitted as friction below none. That nothing has less than none is known
beforehand. But held at none such values draw others; so both are searched, and what is held out
decides, or what was found where the other found nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from pa10d.diagnose.constants import MATERIAL_GAIN, MATERIAL_REST
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.begun import Begun
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.versions import held_out, snapshot
from pa10d.judgement import judged


def or_none_at_least(
    begun: Begun,
    search: Search,
    anew: Callable[[], Begun],
    searched: Callable[[Begun], Search],
) -> tuple[Begun, Search]:
    """The search, or one in which nothing has less than none: if that leaves materially less of
    what is held out, over all joints, or if it alone finds something, and what is held is surely
    below none else. Not made where nothing is left to explain. anew: begins so on the same runs;
    searched: looks in it."""
    state = search.state
    below = {*begun.state.below_none(), *state.below_none()}
    if state.frozen or not below:
        return begun, search
    hides = not _finds(search) and _surely_below(begun, search, below)
    if not hides and _explained(search):
        return begun, search
    other = anew()
    found = searched(other)
    if not (hides and _finds(found)) and _ratio(found.state, state) > np.log(1.0 - MATERIAL_GAIN):
        return begun, search
    return replace(other, as_given=begun.as_given, error=begun.error), found


def _explained(search: Search) -> bool:
    """Does every joint keep no more than noise, held out?"""
    state = search.state
    ratio = judged(state.model.name, held_out(state.model, state)).ratio
    return bool(np.all(ratio <= MATERIAL_REST))  # nan: nobody knows


def _finds(search: Search) -> bool:
    return len(search.state.terms) > search.fixed


def _surely_below(begun: Begun, search: Search, below: Iterable[int]) -> bool:
    """Is one of these terms, by its own errors, no accident? Of its sizes alone: how sharply dry
    friction turns round may lie at the end of what that may be, whatever its size is."""
    fitted = snapshot(begun.model, search.state, search.fixed, begun.as_given)
    return any(
        value.beyond and value.value < 0.0
        for k in below
        for name, value in fitted.term_values(k).items()
        if name in {c.name for c in fitted.terms[k].effect.coefficients}
    )


def _ratio(one: SearchState, other: SearchState) -> float:
    """Logarithm of what one leaves of what the other leaves held out, the mean of all joints."""
    left, of = rms(one.held_residual()), rms(other.held_residual())
    there = (left > 0.0) & (of > 0.0)
    return float(np.mean(np.log(left[there] / of[there]))) if there.any() else 0.0
