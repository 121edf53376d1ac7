"""A link may still swing when the recorder is started: springs are found all the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy
from two_links import COULOMB, CUTOFF, RATE, ROTOR, V0, VISCOUS, robot, state_of
from two_links import recordings as stiff
from unwound import NOISE, recordings, spring_of

from pa10d.diagnose.regression.flexible import Flexible, JointSpring
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.suspects import suspects
from pa10d.judgement import residual_of
from pa10d.model import Term, TorqueModel

MODE, ZETA = 5.0, 0.02  # Hz and 1: it swings on for seconds
I_YY = 6  # of a body's ten parameters
FLOOR = NOISE * np.sqrt(2.0 * CUTOFF / RATE)


@pytest.fixture(scope="module")
def state() -> SearchState:
    return state_of(recordings(*spring_of(MODE, ZETA), seed=1))


def true(state: SearchState) -> TorqueModel:
    """What the recordings were made with."""
    own = {"rotor_inertia": ROTOR, "coulomb": COULOMB, "viscous": VISCOUS}
    terms = []
    for term in state.terms:
        shape = {name: V0 for name in term.shape}
        terms.append(
            replace(term, coefficients=np.array([own[term.effect_id][term.joints[0]]]), shape=shape)
        )
    bodies = robot().parameters.copy()
    if 0 in state.train.contexts[0].rotor_in_load:  # an inertia of the first link, about its axis
        bodies[0, I_YY] += ROTOR[0]
    return replace(state.model, h=state.model.base.of(bodies), terms=tuple(terms), loads=None)


def test_a_model_with_its_spring_is_judged_by_how_its_links_swing_at_first(state):
    stiffness, _ = spring_of(MODE, ZETA)
    model = true(state)
    term = Term("joint_elasticity", (1,), np.ones(1), {"K": stiffness, "zeta": ZETA})
    model = replace(model, terms=(*model.terms, term))
    for run in state.held.runs:
        seen = residual_of(model, run)
        left = [np.std(seen.error[k, j]) for j, k in enumerate(run.keep.T)]
        assert np.all(left < 1.6 * FLOOR)  # first order in 0.1 rad of twist
        rest = run.driven - run.filtered(model.predict(run.context))  # every link hangs still
        assert np.std(rest[run.keep[:, 1], 1]) > 3.0 * FLOOR


def test_a_spring_is_fitted_whatever_it_is_wound_to_at_first(state):
    stiffness, damping = spring_of(MODE, ZETA)
    beta, bodies = state.fit.beta.copy(), true(state).h
    beta[: len(bodies)] = bodies
    found = Flexible(state, [1]).fit(beta, (JointSpring(1, 1.05 * stiffness, damping, 0.0),), 8)
    assert found.springs[0].stiffness == pytest.approx(stiffness, rel=0.02)
    assert found.left < 2.0 * np.log(1.1 * FLOOR)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_spring_that_begins_unwound_is_named():
    runs = recordings(*spring_of(3.0, ZETA), seed=2)
    start = state_of(runs)
    chosen, _ = Search(start, suspects(False, 2), len(start.terms)).spring_beside([])
    assert chosen.place == ("joint_elasticity", (1,))
    assert chosen.candidate.shape["K"] == pytest.approx(spring_of(3.0, ZETA)[0], rel=0.02)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_what_swings_beyond_all_that_is_asked_for_is_named(state):
    search = Search(state.copy(), suspects(False, 2), len(state.terms))
    assert search.swinging([1])
    assert search.state.terms[-1].shape["K"] == pytest.approx(spring_of(MODE, ZETA)[0], rel=0.02)


def _slow(pole: float):
    def made(rng, samples):
        white = rng.standard_normal(samples + 2000)
        return np.sqrt(1.0 - pole**2) * scipy.signal.lfilter([1.0], [1.0, -pole], white)[2000:]

    return made


@pytest.mark.long
@pytest.mark.parametrize(
    "pole", [0.9, *(pytest.param(p, marks=pytest.mark.long) for p in (0.0, 0.99, 0.999))]
)
@pytest.mark.timeout(600)
def test_no_spring_in_a_stiff_arm_whatever_its_noise(pole):
    """Though it is asked for what swings in every joint, with noise at its floor or far above."""
    start = state_of(stiff(seed=3, noise=0.1, colour=_slow(pole)))
    assert not Search(start, suspects(False, 2), len(start.terms)).swinging([1, 0])
