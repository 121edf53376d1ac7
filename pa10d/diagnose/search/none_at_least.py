"""A search with friction and rotor inertia of no less than none, where that foretells better.

What short runs hardly show of a joint, a free fit gives any value, and to motion that it has not
seen that value is an error larger than most effects: what is missing hides behind it. That nothing
has less than none is known beforehand. But what a model lacks draws such values, too, and held at
none they draw others; so both are searched, and what is held out decides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pa10d.diagnose.constants import MATERIAL_GAIN
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.begun import Begun
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.steps import Search


def or_none_at_least(
    begun: Begun,
    search: Search,
    anew: Callable[[], Begun],
    searched: Callable[[Begun], Search],
) -> tuple[Begun, Search]:
    """The search, or one in which nothing has less than none, if that leaves materially less of
    what is held out, over all joints. anew: begins so on the same runs; searched: looks in it."""
    state = search.state
    if state.frozen or not (state.below_none() or begun.state.below_none()):
        return begun, search
    other = anew()
    found = searched(other)
    if _ratio(found.state, state) > np.log(1.0 - MATERIAL_GAIN):
        return begun, search
    return replace(other, as_given=begun.as_given, error=begun.error), found


def _ratio(one: SearchState, other: SearchState) -> float:
    """Logarithm of what one leaves of what the other leaves held out, the mean of all joints."""
    left, of = rms(one.held_residual()), rms(other.held_residual())
    there = (left > 0.0) & (of > 0.0)
    return float(np.mean(np.log(left[there] / of[there]))) if there.any() else 0.0
