"""A joint that the fit side hardly moved says nothing of an effect on another joint."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import V0, recordings, state_of

from pa10d.diagnose.evidence.held_out import ModelUncertainty
from pa10d.diagnose.regression.partial import partials
from pa10d.diagnose.search.candidates import Candidate
from pa10d.diagnose.search.judging import Judging
from pa10d.diagnose.search.suspects import suspicion
from pa10d.effects import effect
from pa10d.effects.base import smooth_sign


def bump(t, q, dq, ddq):
    """(N, 2) N·m: the first joint's friction is higher below 0.25 rad/s."""
    along = 1.2 * np.exp(-((dq[:, 0] / 0.25) ** 2)) * smooth_sign(dq[:, 0], V0)
    return np.outer(along, [1.0, 0.0])


def test_what_another_joint_does_not_know_is_no_evidence():
    """Bodies that the fit side hardly moved are so unsure on the held-out side that what a right
    effect shifts there, by way of them, would drown what its own joint says."""
    state = state_of(recordings(3, bump, 0.1))
    kind, shape = effect("stribeck"), {"vs": 0.25, "delta": 2.0}
    judging = Judging(state, suspicion(("stribeck", ()), 2), len(state.terms))
    (partial,) = partials(state.fit, state.train.columns(kind, (0,), [shape]), kind, 1)
    candidate = Candidate(kind, (0,), shape, partial)
    residual = state.held_residual()
    change = state.change(
        state.fit,
        state.held.columns(candidate.effect, (0,), [candidate.shape]),
        candidate.partial.seen,
        candidate.partial.theta,
    )
    change[1] = np.full_like(residual[1], 0.01)
    unsure = {0: np.zeros((len(residual[0]), 1)), 1: np.ones((len(residual[1]), 1))}
    for error in (0.0, 10.0):
        doubt = ModelUncertainty(unsure, np.array([[error**2]]))
        found = judging._evidence(residual, change, doubt, judging._told(candidate, residual, None))
        assert found.p_value < 1e-6
        assert found.slope == pytest.approx(1.0, abs=0.2)
        assert found.after[1] != found.before[1], "what it does there is still told"
