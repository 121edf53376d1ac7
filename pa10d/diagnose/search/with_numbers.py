"""Changes of a frozen model that are told: those of which at least one number is an estimate."""

from __future__ import annotations

from collections.abc import Sequence

from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.versions import snapshot
from pa10d.judgement import RunResidual
from pa10d.model import TorqueModel
from pa10d.model.estimates import not_one


def only_with_numbers(search: Search, given: TorqueModel, as_given: Sequence[RunResidual]) -> None:
    """Drop what was found and has not one number that the data determine: all that is known of it
    is that columns of such a shape take something, and so does whatever a model lacked before.

    as_given: the held-out side as the given model saw it
    """
    while len((state := search.state).terms) > search.fixed:
        version = snapshot(given, state, len(state.terms), as_given)
        none = [
            index
            for index in range(search.fixed, len(state.terms))
            if not_one(state.terms[index], version.term_values(index))
        ]
        if not none:
            return
        for index in reversed(none):
            state.drop(index)
        search.settle()
