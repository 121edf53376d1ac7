"""Effects that follow an angle may be parts of one curve: bodies are as unsure as that says."""

from __future__ import annotations

import numpy as np
import pytest
from test_geometry import model_of
from test_zeros_and_tilt import FIT, HELD, of_turret, turret

from pa10d.diagnose.evidence.curves import angles_of, open_to_curves, parts_of_curves
from pa10d.diagnose.evidence.stated import stated
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.model import Term

NOTHING = np.zeros(2)


def cam(angle):
    """A curve over the angle, N·m, of which a spring and a ripple leave what looks like gravity."""
    return 2.5 * angle - 1.5 * np.sin(angle) + 0.3 * np.cos(4.0 * angle)


def with_parts(order):
    """The state with a spring and a ripple of this order, cycles a turn, on the second joint, whose
    gravity follows its angle alone, as the cam does that is there."""
    runs = of_turret(turret(), np.zeros(3), 0.0)
    for run in runs.values():
        run.tau[:, 1] += cam(run.q[:, 1])
    sides = two_sides(model_of(runs, turret()), [runs[n] for n in FIT], [runs[n] for n in HELD])
    state = SearchState.start(model_of(runs, turret()), *sides[:2])
    given = len(state.terms)
    state.push(Term("spring", (1,), NOTHING, {}))
    state.push(Term("torque_ripple", (1,), NOTHING, {"N": order}))
    state.refit()
    return state, [given, given + 1]


@pytest.mark.long
def test_bodies_are_as_far_off_as_they_say():
    """What their gravity is off by had no part in it."""
    state, found = with_parts(4.0)
    truth = state.model.base.of(np.ravel(turret().parameters))
    names = state.model.parameter_names()
    gravity = [k for k, name in enumerate(names[: len(truth)]) if name in ("mx2", "mz2")]
    away = np.abs(state.model.h - truth)[gravity]
    error = np.sqrt(np.diag(stated(state, found).covariance))[gravity]
    before = np.sqrt(np.diag(stated(state, ()).covariance))[gravity]
    assert np.max(away / before) > 5.0
    assert np.max(away / error) < 3.0


@pytest.mark.long
@pytest.mark.parametrize("order", [60.0])
def test_a_ripple_that_was_seen_over_many_turns_is_none(order):
    state, found = with_parts(order)
    assert parts_of_curves(list(enumerate(state.terms))[found[0] :], angles_of(state)) == {}
    assert not open_to_curves(state, found).any()


def test_one_effect_alone_is_no_curve():
    state, found = with_parts(4.0)
    assert not open_to_curves(state, found[:1]).any()
    assert not open_to_curves(state, found[1:]).any()
