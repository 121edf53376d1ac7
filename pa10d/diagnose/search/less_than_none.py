"""Friction that comes out below nothing, where nothing was found: looked for again without it.

No joint has less friction than none. Where a fit wants it, something else has drawn it: what a
servo answers to cogging, say, which runs against the speed that the cogging makes. Such a term fits
that, and hides it: a motor's cogging left "nothing that was looked for". Without it the error is
larger, and what is missing shows in it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pa10d.diagnose.search.begun import Begun
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.versions import snapshot
from pa10d.model import TorqueModel
from pa10d.model.estimates import no_estimates


@dataclass(frozen=True)
class LeftOut:
    """What was looked for without terms of the given model; words: on each of those."""

    begun: Begun
    search: Search
    words: tuple[str, ...] = ()


def or_without_impossible(
    begun: Begun,
    search: Search,
    anew: Callable[[TorqueModel], Begun],
    searched: Callable[[Begun], Search],
) -> LeftOut:
    """The search, or where it found nothing beside friction below nothing, one without that which
    finds something. anew: begins with another model on the same runs; searched: looks in it."""
    as_it_is = LeftOut(begun, search)
    if len(search.state.terms) > search.fixed or search.state.frozen:
        return as_it_is
    fitted = snapshot(begun.model, search.state, search.fixed, begun.as_given)
    said = {k: _below_nothing(fitted, k) for k in range(search.fixed)}
    gone = [k for k, words in said.items() if words]
    if not gone:
        return as_it_is
    other = anew(_without(begun.whole, gone))
    found = searched(other)
    if len(found.state.terms) == found.fixed:
        return as_it_is
    judged = replace(other, as_given=begun.as_given, error=begun.error)
    return LeftOut(judged, found, tuple(said[k] for k in gone))


def _below_nothing(model: TorqueModel, index: int) -> str:
    """What is to be said of a term that the textbook has, if nothing can have as little."""
    term = model.terms[index]
    values = model.term_values(index)
    least = {c.name: c.lower for c in term.effect.coefficients}
    below = any(v.beyond and v.value < least.get(name, v.value) for name, v in values.items())
    return no_estimates(term, values) if below and term.effect.question == "textbook" else ""


def _without(model: TorqueModel, gone: Sequence[int]) -> TorqueModel:
    """The model without some of its terms; what it was known to be as a whole goes with them."""
    places = np.concatenate(
        [np.arange(model.covariance.shape[0])[model.term_slice(k)] for k in gone]
    )
    kept = np.delete(np.arange(model.covariance.shape[0]), places)
    terms = tuple(t for k, t in enumerate(model.terms) if k not in gone)
    covariance = model.covariance[np.ix_(kept, kept)]
    return replace(model, terms=terms, covariance=covariance, standard=None, feasible=False)
