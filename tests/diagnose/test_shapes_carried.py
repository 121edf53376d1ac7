"""A shape that slow motion hardly knows, asked for by fast motion.

On a slide whose power of the speed was fitted as 2.6 for 2.1, what that left at three times the
speed was "no noise, but what it depends on is not known".
"""

from __future__ import annotations

import numpy as np
import pytest
from two_links import NAMES, motion, state_of, textbook_torque

from pa10d.diagnose.constants import CARRIED_FARTHER
from pa10d.diagnose.evidence.errors_of import carried_farther, moved_by_shapes, term_covariance
from pa10d.measurement.recording import Recording
from pa10d.model import Term

SLOW, POWER = 0.4, 2.0


def churned(name: str, seed: int, pace: float) -> Recording:
    """The second joint churns oil: 0.3 N·m·(s/rad)² more."""
    t, q, dq, ddq = motion(seed)
    rng = np.random.default_rng(seed)
    dq, ddq = pace * dq, pace**2 * ddq
    tau = textbook_torque(q, dq, ddq)
    tau[:, 1] += 0.3 * np.abs(dq[:, 1]) ** POWER * np.sign(dq[:, 1])
    return Recording(name, t / pace, q, tau + 0.05 * rng.standard_normal(q.shape))


def with_its_power(pace: float):
    """A model that knows the effect and its shape, and how many terms it had before."""
    runs = {
        name: churned(name, 40 + k, pace if name.startswith("fit") else 1.0)
        for k, name in enumerate(NAMES)
    }
    state = state_of(runs)
    first = len(state.terms)
    state.push(Term("nonlinear_viscous", (1,), np.zeros(1), {"p": POWER}))
    state.refit()
    return state, first


@pytest.mark.by_default("0.4")
@pytest.mark.parametrize(("pace", "farther"), [(SLOW, True), (1.0, False)])
def test_it_counts_as_much_as_the_motion_to_judge_asks_for_it(pace, farther):
    state, first = with_its_power(pace)
    moved = moved_by_shapes(state, first)
    nothing = np.zeros((state.fit.beta.size,) * 2)
    assert (carried_farther(state, nothing, moved)[1] > CARRIED_FARTHER) == farther
    assert np.all(moved_by_shapes(state, len(state.terms)) == 0.0)


@pytest.mark.long
def test_it_is_what_a_standard_error_of_the_shape_moves():
    state, first = with_its_power(SLOW)
    error = term_covariance(state, first, of_noise=True)[1]["p"]
    off, _ = with_its_power(SLOW)
    off.replace_term(first, Term("nonlinear_viscous", (1,), np.zeros(1), {"p": POWER + error}))
    off.refit()
    apart = off.held_residual()[1] - state.held_residual()[1]
    assert moved_by_shapes(state, first)[1, 1] == pytest.approx(np.sqrt(np.mean(apart**2)))
