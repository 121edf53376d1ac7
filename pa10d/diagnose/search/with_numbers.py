"""Changes of a frozen model that are told: those of which at least one number is an estimate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.versions import snapshot
from pa10d.effects import Value
from pa10d.judgement import RunResidual
from pa10d.model import Term, TorqueModel
from pa10d.model.estimates import not_one


def only_with_numbers(search: Search, given: TorqueModel, as_given: Sequence[RunResidual]) -> None:
    """Drop what was found and has not one number that the data determine: all that is known of it
    is that columns of such a shape take something, and so does whatever a model lacked before. What
    is larger than it may be is no estimate either, but a larger change is not told less.

    as_given: the held-out side as the given model saw it
    """
    while len((state := search.state).terms) > search.fixed:
        version = snapshot(given, state, len(state.terms), as_given)
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


def too_large(term: Term, found: Mapping[str, Value]) -> bool:
    """Is one of its sizes beyond the far end of what it may be?"""
    return any(
        c.name in found
        and found[c.name].beyond
        and (found[c.name].value >= c.upper or found[c.name].value <= c.lower < 0.0)
        for c in term.effect.coefficients
    )
