"""Dry friction that turns round more sharply than identification has it is no Stribeck friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from two_links import COULOMB, V0, recordings, state_of

from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.corners import sharpened
from pa10d.diagnose.search.steps import Search
from pa10d.effects import effect

BLUNT = 4.0 * V0
ASKED = [(effect("stribeck"), (0,))]


def surely_blunt(state: SearchState) -> SearchState:
    """With a corner of joint 1 that is known to 5 %, and wrong."""
    names = [(t.effect_id, t.joints) for t in state.terms]
    index = names.index(("coulomb", (0,)))
    term = state.terms[index]
    state.replace_term(
        index, replace(term, shape={**term.shape, "v0": BLUNT}, shape_errors={"v0": 0.05 * BLUNT})
    )
    state.refit()
    return state


def test_a_blunt_corner_is_sharpened_instead_of_being_called_stribeck_friction():
    """A way of 0.3 mrad had made it blunt as the joint turned round: "Stribeck friction" took 70 %
    of its error in steady motion, none of its numbers determined."""
    state = surely_blunt(state_of(recordings(2)))
    blunt = state.held_residual()[0]
    search = Search(state, ASKED, len(state.terms)).run()
    assert len(search.state.terms) == len(state.terms)
    assert np.std(search.state.held_residual()[0]) < 0.7 * np.std(blunt)
    assert search.sharpened == {0}


def test_a_blunt_corner_of_a_model_as_it_was_is_no_change():
    """An arm that had only got a load was told to have "Stribeck friction … no change" besides."""
    given = surely_blunt(state_of(recordings(2))).model
    state = state_of(recordings(4), given, frozen=True)
    blunt = state.held_residual()[0]
    search = Search(state, ASKED, len(state.terms)).run()
    assert len(search.state.terms) == len(state.terms)
    assert np.std(search.state.held_residual()[0]) < 0.7 * np.std(blunt)
    ((was, now),) = sharpened(given, search.state).values()
    assert was == BLUNT
    assert now < 0.7 * BLUNT


def test_stribeck_friction_beside_a_blunt_corner_is_named():
    def extra(t, q, dq, ddq):
        bump = 0.8 * COULOMB[0] * np.exp(-((dq[:, 0] / 0.2) ** 2)) * np.tanh(dq[:, 0] / V0)
        return np.column_stack([bump, np.zeros(len(t))])

    state = surely_blunt(state_of(recordings(2, extra)))
    search = Search(state, ASKED, len(state.terms)).run()
    (found,) = search.state.terms[len(state.terms) :]
    assert abs(found.coefficients[0] - 0.8 * COULOMB[0]) < 0.1 * COULOMB[0]
    assert abs(found.shape["vs"] - 0.2) < 0.01
