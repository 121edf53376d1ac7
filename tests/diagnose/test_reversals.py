"""What reversals do to estimates although they are left out, and that errors know of it."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import recordings, state_of, textbook

from pa10d.diagnose.evidence.errors_of import term_covariance
from pa10d.diagnose.evidence.reversals import moved_by_reversals
from pa10d.diagnose.regression.slopes import with_slopes
from pa10d.diagnose.search.steps import Search
from pa10d.effects import effect

TRUE = {"Fs": 1.0, "vs": 0.3, "delta": 1.5}
KNOCK, SLOW = 6.0, 0.1  # N·m, rad/s


def bump(t, q, dq, ddq):
    """Stribeck friction in joint 1."""
    speed = np.abs(dq[:, 0])
    rise = TRUE["Fs"] * np.exp(-((speed / TRUE["vs"]) ** TRUE["delta"]))
    return np.column_stack([rise * np.sign(dq[:, 0]), np.zeros(len(t))])


def bump_that_sticks(t, q, dq, ddq):
    """The same, and a torque that nobody models in the instant of each reversal."""
    stuck = KNOCK * np.exp(-((dq[:, 0] / SLOW) ** 2)) * np.sign(ddq[:, 0])
    return bump(t, q, dq, ddq) + np.column_stack([stuck, np.zeros(len(t))])


def found_in(extra, seed, noise):
    """How far the estimates (3,) are off; their errors as reported; and the part of these that
    reversals have."""
    state = state_of(recordings(seed, extra, noise), textbook(recordings(0)))
    search = Search(state, [(effect("stribeck"), (0,))], len(state.terms))
    state.push(search.best(effect("stribeck"), (0,)).term)
    search.settle()
    state = search.state
    index, term = len(state.terms) - 1, state.terms[-1]
    covariance, shape_errors = term_covariance(state, index)
    reported = np.array([np.sqrt(covariance[0, 0]), shape_errors["vs"], shape_errors["delta"]])
    slopes = {j: c[:, 1:] for j, c in with_slopes(state.train, term).items()}
    moved = moved_by_reversals(state, index, slopes, np.zeros(3))  # nothing taken off for noise
    values = np.array([term.coefficients[0], term.shape["vs"], term.shape["delta"]])
    return np.abs(values - list(TRUE.values())), reported, np.sqrt(moved)


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.long) for k in (2, 3))])
def test_errors_hold_the_truth_where_the_joint_sticks(seed):
    off, errors, _ = found_in(bump_that_sticks, seed, noise=0.005)
    _, of_noise, _ = found_in(bump, seed, noise=0.005)
    assert np.all(off < 4 * errors)
    assert np.all(off > 4 * of_noise), "noise alone does not explain it"


def test_where_nothing_sticks_errors_are_those_of_noise():
    _, errors, moved = found_in(bump, 1, noise=0.005)
    assert np.all(moved < 1.2 * errors)
