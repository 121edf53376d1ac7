"""All that rubs in a joint turns round over one speed, unless the data show another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from two_links import recordings, robot, state_of

from pa10d.diagnose.search.refining import refine
from pa10d.dynamics import inverse_dynamics
from pa10d.model import Term


def test_friction_of_the_load_turns_round_where_dry_friction_does():
    """Fast crossings show no corner of 0.02 rad/s; the fit side alone would take it for one."""

    def rubbing(t, q, dq, ddq):
        load = inverse_dynamics(robot(), robot().parameters, q, dq, ddq)
        return np.column_stack([0.12 * np.abs(load[:, 0]) * np.sign(dq[:, 0]), 0.0 * t])

    state = state_of(recordings(6, rubbing, noise=0.3))
    names = [(t.effect_id, t.joints) for t in state.terms]
    place = names.index(("coulomb", (0,)))
    dry = state.terms[place]
    state.replace_term(place, replace(dry, shape={"v0": 0.002}))
    given = len(state.terms)
    state.push(Term("load_friction", (0,), np.array([0.1]), {"v0": 0.02, "rotor": 0.3}))
    state.refit()
    refine(state, given, given)
    assert state.terms[given].shape["v0"] == 0.002
