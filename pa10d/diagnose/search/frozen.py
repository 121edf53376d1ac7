"""What may have changed of a model that stays as it was: how far it moves, which changes are looked
for, and what is said where one would do that was not named."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import BROKEN_SHARE, FIRM, MATERIAL_GAIN, MATERIAL_REST, USUAL
from pa10d.diagnose.regression.state import SearchState, Suspects
from pa10d.diagnose.search.harm import less_likely, rms
from pa10d.diagnose.search.judging import Place, spoken_of
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.suspects import heard, suspects
from pa10d.diagnose.search.with_numbers import only_with_numbers
from pa10d.diagnose.unknown.as_it_stood import (
    Alone,
    OneChange,
    alone_words,
    left_far_more,
    stood_words,
)
from pa10d.effects import Effect
from pa10d.judgement import Judgement, RunResidual
from pa10d.model import TorqueModel

Array = NDArray[np.float64]


def kept_as_it_was(state: SearchState, model: TorqueModel, given: Judgement) -> SearchState:
    """The same, moved within the model's doubt to suit the fit side only as far as that does not
    leave materially more of the other one; it knows what the model left, and may leave. given: of
    the model as it was given, held out."""
    firmness = 1.0
    while firmness < FIRM**2 and _harmed(state, given.rms):
        firmness *= FIRM
        state = SearchState.start(model, state.train, state.held, True, firmness)
    state.usual, state.as_given = _usual(model, given), given.rms
    return state


def _harmed(state: SearchState, as_given: Array) -> bool:
    return less_likely(rms(state.held_residual()) / ((1.0 + MATERIAL_GAIN) * as_given))


def _usual(model: TorqueModel, given: Judgement) -> Array:
    """(n,) N·m RMS that a model may leave though nothing changed: the noise, and some more than it
    lacked on the data that it was identified from. Where the noise is not known all
    that it left may be what it lacked."""
    floor = np.nan_to_num(given.floor.values)
    return np.asarray(np.hypot(floor, USUAL * np.sqrt(np.maximum(model.noise**2 - floor**2, 0.0))))


def always_lacked(
    kind: Effect, joints: Sequence[int], model: TorqueModel, given: Judgement
) -> bool:
    """May what a model always lacked pose as this change? Friction that it never had shows more in
    one motion than in another, and a law with a shape of its own bends to it: no farther than what
    a joint may usually leave."""
    own = list(joints)
    bends = any(not (s.smoothing or s.optional) for s in kind.shapes)
    lacked = model.noise[own] > MATERIAL_REST * given.floor.values[own]
    as_ever = given.rms[own] <= _usual(model, given)[own]
    return kind.question == "missing" and bends and bool(np.any(lacked & as_ever))


def new_kinds(model: TorqueModel, given: Judgement, search: Search) -> Suspects:
    """Where what usually changes explains no more, and a joint keeps more than its noise: what else
    of the library may have come, a gear's ripple or its play, on such joints alone."""
    left, floor = rms(search.state.held_residual()), given.floor.values
    usual = search.state.usual
    keeps = left > MATERIAL_REST * floor
    keeps &= True if usual is None else left > usual
    asked = {(kind.id, joints) for kind, joints in search.suspects}
    return [
        (kind, joints)
        for kind, joints in heard(suspects(False, model.robot.n), search.state.held)
        if (kind.id, joints) not in asked
        and any(keeps[j] for j in joints)
        and not always_lacked(kind, joints, model, given)
    ]


def held_firmly(search: Search, model: TorqueModel, as_given: Sequence[RunResidual]) -> Search:
    """Where one change alone, all else as it was, explains what was found otherwise or not at all
    while the model moved within its doubt: the search of one that hardly moves, if it names that
    change and leaves less."""
    state, given = search.state, search.fixed
    if state.usual is None or state.as_given is None:
        return search
    alone = Alone.of(state, model, heard(suspects(True, model.robot.n), state.held))
    own = alone.on_their_own(state.as_given > state.usual, model.noise)
    would_do = {one.place for one in (alone.one(), *own.values()) if one is not None}
    would_do -= _found(search)
    if not would_do:
        return search
    firm = SearchState.start(model, state.train, state.held, True, FIRM)
    firm.usual, firm.as_given = state.usual, state.as_given
    other = Search(firm, search.suspects, given, progress=search.progress)
    other.run()
    only_with_numbers(other, model, as_given)
    better = less_likely(rms(state.held_residual()) / rms(other.state.held_residual()))
    return other if better and would_do & _found(other) else search


def _found(search: Search) -> set[Place]:
    return {(term.effect_id, term.joints) for term in search.state.terms[search.fixed :]}


@dataclass(frozen=True)
class AsItStood:
    """far (n,) joints of which the model as it was given leaves more than usual, or that one change
    would explain; words: of all of them together, empty where there is none; alone: by joint, in
    words, what one change takes there."""

    far: NDArray[np.bool_]
    words: str = ""
    alone: Mapping[int, str] = field(default_factory=dict)


def as_it_stood(
    search: Search,
    model: TorqueModel,
    given: Judgement,
    left: Judgement,
    moved: Array,
    asked: Suspects | None,
) -> AsItStood:
    """Held out; given: as the model was; left: with all findings; moved (n,) N·m RMS: where it
    moves as far as its doubt allows; asked: one suspicion in some places, None: all there are."""
    state, n = search.state, model.robot.n
    if state.usual is None:
        return AsItStood(np.zeros(n, dtype=bool))
    far = left_far_more(state, moved, left.rms, given.floor.values)
    spoken = spoken_of(state.terms[search.fixed :], n)
    far &= ~(spoken & (left.rms <= state.usual))
    rest = ~(far | spoken | (given.rms <= MATERIAL_REST * given.floor.values))
    may_change = heard(suspects(True, n), state.held) if asked is None else asked
    changes = _changes(search, model, far, rest, may_change)
    if asked is not None:
        far = np.zeros(n, dtype=bool)  # of one suspicion: where it would do
    if changes is None:
        return AsItStood(far)
    far[[*changes]] = True
    units = [model.robot.torque_unit(j) for j in range(n)]
    return AsItStood(
        far,
        stood_words(given.rms, moved, model.noise, far, changes),
        alone_words(given.rms, changes, units),
    )


def _changes(
    search: Search,
    model: TorqueModel,
    far: NDArray[np.bool_],
    rest: NDArray[np.bool_],
    may_change: Suspects,
) -> dict[int, OneChange] | None:
    """By joint, what one change would do there, all else as it was: the same one on all that are
    left far more, ``far``, or one of its own, there and on the ``rest``, (n,) masks. None where a
    finding says it."""
    alone = Alone.of(search.state, model, may_change)
    change = alone.one() if far.any() else None
    if change is not None and change.place in _found(search):
        return None
    told = alone.on_their_own(far | rest, model.noise)
    if change is not None:
        took = np.flatnonzero(far & (change.shares >= BROKEN_SHARE)).tolist()
        told |= dict.fromkeys(took, change)
    return told
