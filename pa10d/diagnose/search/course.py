"""A search from its first step to its last: what is asked, and what has to hold in the end."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pa10d.diagnose.constants import MATERIAL_REST
from pa10d.diagnose.regression.state import Suspects
from pa10d.diagnose.search.begun import Begun
from pa10d.diagnose.search.frozen import (
    always_lacked,
    held_firmly,
    kept_as_it_was,
    new_kinds,
)
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.noisy_angles import none_of_noise
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.suspects import heard, suspects, suspicion
from pa10d.diagnose.search.with_numbers import (
    needed_beside_springs,
    needed_without_numbers,
    only_with_numbers,
)

Only = tuple[str, Sequence[int]]
"""One suspicion: an effect's id, and joints (0-based; empty: wherever it may sit)."""


def searched(
    begun: Begun, only: Only | None, steps: int | None, progress: Callable[[float, str], None]
) -> Search:
    """With what is missing, or in a frozen model what changed, in its state. steps: no more than
    these; progress: called with (share done, what is being done)."""
    n = begun.model.robot.n
    asked = suspects(begun.state.frozen, n) if only is None else suspicion(only, n)
    asked = heard(asked, begun.state.held)
    if begun.state.frozen:
        search = _what_changed(begun, asked, only, steps, progress)
    else:
        search = _what_is_missing(begun, asked, steps, progress)
    if only is None:
        search.contest()
    return search


def _what_is_missing(
    begun: Begun, asked: Suspects, steps: int | None, progress: Callable[[float, str], None]
) -> Search:
    search = Search(begun.state, asked, begun.given, begun.error.floor.values, progress=progress)
    search.run(steps)
    more = steps is None or len(search.steps) < steps
    if more and search.swinging(_keeps(begun, search)):
        search.run(steps)
    gone = refused = needed_without_numbers(search, begun.model, begun.as_given)
    while gone and (steps is None or len(search.steps) < steps):  # what they stood in for may yet
        search.go_on_without(refused, steps)  # come, now that they are not in its way
        gone = needed_without_numbers(search, begun.model, begun.as_given)
        refused |= gone
    needed_beside_springs(search)
    none_of_noise(search, begun.model, begun.as_given)
    return search


def _what_changed(
    begun: Begun,
    asked: Suspects,
    only: Only | None,
    steps: int | None,
    progress: Callable[[float, str], None],
) -> Search:
    model, error = begun.model, begun.error
    state = kept_as_it_was(begun.state, model, error)
    asked = [one for one in asked if only or not always_lacked(*one, model, error)]
    search = Search(state, asked, begun.given, error.floor.values, progress=progress)
    search.run(steps)
    if only is not None:
        return search
    search.suspects = [*asked, *new_kinds(model, error, search)]
    if len(search.suspects) > len(asked):
        search.run(steps)
    only_with_numbers(search, model, begun.as_given)
    return held_firmly(search, model, begun.as_given)


def _keeps(begun: Begun, search: Search) -> list[int]:
    """Joints that keep materially more than their noise, those that keep most of it first."""
    ratio = rms(search.state.held_residual()) / begun.error.floor.values
    return [int(j) for j in np.argsort(-ratio) if ratio[j] > MATERIAL_REST]
