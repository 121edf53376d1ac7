"""Torque's offset in time is taken anew beside what was found: what was missing posed as some."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_channel_beside_findings import HALF, between_hard_teeth
from two_links import NAMES, recordings, state_of, textbook

from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.shape_slopes import shape_slopes
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.suspects import suspects
from pa10d.diagnose.search.timing import joint_delays
from pa10d.model import Term

OFF = 1e-3  # s
FAR = 9e-3  # s: more samples than an offset that identification found is corrected by


def off_by(seconds: float) -> Search:
    """A search whose offset was taken beside something that has been found since."""
    state = state_of(recordings(3, lambda t, *moved: np.outer(np.ones(len(t)), [1.0, 0.0])))
    search = Search(state, suspects(False, 2), len(state.terms))
    state.train, state.held = state.train.shifted(seconds), state.held.shifted(seconds)
    state.push(Term("torque_offset", (0,), np.ones(1)))
    state.refit()
    return search


@pytest.mark.parametrize("off", [OFF, FAR])
def test_an_offset_that_was_taken_too_early_is_taken_anew(off):
    """A gap had kept identification from 22 ms, and both its joints were told "measured late"."""
    search = off_by(off)
    before = search.state.train.runs[0].shift
    assert search._in_time()
    assert search.state.train.runs[0].shift == pytest.approx(before - off, abs=0.2 * OFF)


def test_a_knock_that_comes_too_early_is_no_offset(monkeypatch):
    """Teeth twice as hard as a gap's are taken to be asked for 2.6 ms on both joints; an arm behind
    12 Hz stayed 6 ms off, had a channel of 8.8 Hz and friction that its joints shared."""
    made, late = recordings(3, between_hard_teeth), textbook(recordings(3))
    runs = [made[name] for name in NAMES]
    train, held, _ = two_sides(replace(late, shift=-4.0 * OFF, channel=None), runs[:2], runs[2:])
    state = SearchState.start(late, train, held)
    search = Search(state, suspects(False, 2), len(state.terms))
    state.push(Term("backlash", (1,), np.ones(1), {"b": HALF}))
    state.refit()
    state.relook()
    state.refit()
    monkeypatch.setattr(Search, "settle", lambda self: self.state.refit())  # shapes as they are
    assert search._in_time()
    assert search.state.train.runs[0].shift == pytest.approx(0.0, abs=0.6 * OFF)


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
