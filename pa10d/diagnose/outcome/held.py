"""Which of the textbook's terms a search held at none, and why a fit wanted less."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pa10d.common.words import listed
from pa10d.diagnose.regression.state import SearchState
from pa10d.model import TorqueModel
from pa10d.model.estimates import BEYOND

SURELY = "wants surely less, which no joint has: something else has drawn {it}"
PERHAPS = "wants less, which no joint has, but within its doubt: these runs hardly show {it}"


@dataclass(frozen=True)
class HeldAtNone:
    """A term by its label; surely: the free fit is below none by its own errors."""

    label: str
    surely: bool


def held_at_none(model: TorqueModel, state: SearchState) -> tuple[HeldAtNone, ...]:
    """model: as it was made of the state, with the errors of the free fit."""
    return tuple(_held(model, state))


def _held(model: TorqueModel, state: SearchState) -> Iterator[HeldAtNone]:
    free, errors = state.as_free().fit.beta, np.sqrt(np.maximum(np.diag(model.covariance), 0.0))
    for index in state.at_none():
        place = state.place(index)
        surely = np.any(free[place] < -BEYOND * errors[place])
        yield HeldAtNone(state.terms[index].label, bool(surely))


def held_words(terms: Sequence[HeldAtNone]) -> tuple[str, ...]:
    """A sentence for each reason."""
    said = []
    for surely, why in ((True, SURELY), (False, PERHAPS)):
        labels = [one.label for one in terms if one.surely == surely]
        if labels:
            one = len(labels) == 1
            held = f"{listed(labels)} {'is' if one else 'are'} held at none: a fit to these runs "
            said.append(held + why.format(it="it" if one else "them"))
    return tuple(said)
