"""What is held at none does not come back as another effect of bodies that cannot be."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from two_links import ROTOR, recordings, state_of

from pa10d.diagnose.search.possible import through_impossible_bodies
from pa10d.diagnose.search.rivals import rival_yet
from pa10d.diagnose.search.steps import Search
from pa10d.model import Term

WHEEL = Term("coupling_inertia", (0, 1), np.zeros(1), {})


def beside(extra):
    """Both states of an arm with more torque: without coupled inertia, and with it."""
    before = state_of(recordings(5, extra=extra), none_at_least=True)
    after = before.copy()
    after.push(WHEEL)
    after.refit()
    return before, after


@pytest.fixture(scope="module")
def less_than_none():
    """Joint 2 has less inertia than none, as where its viscous friction is measured late."""
    return beside(lambda t, q, dq, ddq: np.column_stack([0 * t, -(ROTOR[1] + 0.4) * ddq[:, 1]]))


@pytest.fixture(scope="module")
def shared_wheel():
    """A wheel turns with both, and couples them by more than the rotor of joint 2."""
    both = (ROTOR[1] + 0.05) * np.eye(2)[::-1]
    return beside(lambda t, q, dq, ddq: ddq @ both)


def test_a_rotor_below_none_is_no_coupled_inertia(less_than_none):
    """On parallel axes it is a link's inertia less both rotors': one that was late was told so."""
    before, after = less_than_none
    assert after.free is not None
    assert after.fit.rms()[1] < 0.5 * before.fit.rms()[1], "it takes the error all the same"
    assert through_impossible_bodies(before, after)


def test_a_wheel_that_both_share_is_one(shared_wheel):
    before, after = shared_wheel
    assert after.free is not None
    assert after.fit.rms()[0] < 0.8 * before.fit.rms()[0]
    assert not through_impossible_bodies(before, after)


def test_it_is_neither_taken_nor_told_as_a_rival(less_than_none):
    before, after = less_than_none
    suspects = [(after.terms[-1].effect, (0, 1))]
    search = Search(before.copy(), suspects, len(before.terms))
    search.run(steps=1)
    assert len(search.state.terms) == search.fixed
    rival = SimpleNamespace(candidate=SimpleNamespace(term=WHEEL, effect=after.terms[-1].effect))
    late = before.copy()
    late.push(Term("torque_delay", (1,), np.zeros(1), {}))
    late.refit()
    assert not rival_yet(late, len(late.terms) - 1, rival, len(before.terms))


def test_without_a_term_nothing_has_less_than_none_either():
    """A spring that is left out makes a rotor lighter than none: a fit of what is left held it
    there only if it was held beside the spring, too, and so explained the spring away."""
    runs = recordings(6, extra=lambda t, q, dq, ddq: np.column_stack([0 * t, 8.0 * q[:, 1]]))
    state = state_of(runs, none_at_least=True)
    state.push(Term("spring", (1,), np.zeros(1), {"q0": 0.0}))
    state.refit()
    index = len(state.terms) - 1
    assert state.free is None
    assert state.below_none(state.fit.without(state.place(index)))
    assert not state.below_none(state.fit_without(index))
