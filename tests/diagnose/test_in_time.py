"""Torque's offset in time is taken anew beside what was found: what was missing posed as some."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import recordings, state_of

from pa10d.diagnose.search.shape_slopes import shape_slopes
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.suspects import suspects
from pa10d.diagnose.search.timing import joint_delays
from pa10d.model import Term

OFF = 1e-3  # s


def off_by(seconds: float) -> Search:
    """A search whose offset was taken beside something that has been found since."""
    state = state_of(recordings(3, lambda t, *moved: np.outer(np.ones(len(t)), [1.0, 0.0])))
    search = Search(state, suspects(False, 2), len(state.terms))
    state.train, state.held = state.train.shifted(seconds), state.held.shifted(seconds)
    state.push(Term("torque_offset", (0,), np.ones(1)))
    state.refit()
    return search


def test_an_offset_that_was_taken_too_early_is_taken_anew():
    search = off_by(OFF)
    before = search.state.train.runs[0].shift
    assert search._in_time()
    assert search.state.train.runs[0].shift == pytest.approx(before - OFF, abs=0.1 * OFF)


def test_one_that_is_right_stays():
    assert not off_by(0.0)._in_time()


def test_a_joint_whose_spring_may_damp_it_knows_less_of_how_late_it_is():
    """What a stiff spring's damping does to the torque of its link is a delay."""
    state = state_of(recordings(3))
    state.push(Term("joint_elasticity", (0,), np.ones(1), {"K": 3e4, "zeta": 0.1, "rotor": 0.4}))
    state.refit()
    _, alone = joint_delays(state)
    _, along = joint_delays(state, shape_slopes(state))
    assert along[0] > 1.5 * alone[0]
    assert along[1] == pytest.approx(alone[1], rel=0.5)
