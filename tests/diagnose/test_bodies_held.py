"""Directions that the fitted runs hardly show stay where the given model has them."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import two_links

from pa10d.diagnose.constants import CARRIED_FARTHER
from pa10d.diagnose.evidence.errors_of import carried_farther, honest_covariance
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.harm import rms
from pa10d.dynamics import robot_from_urdf
from pa10d.identify.procedure import identify

sys.path.append(str(Path(__file__).parents[1] / "identify"))
from test_joint_by_joint import HEAVIER, sweeps


@cache
def runs():
    return two_links.recordings()


@cache
def refitted() -> SearchState:
    """A model that was identified from rich motion, to sweeps of one joint after the other."""
    train, held, _ = two_sides(two_links.textbook(runs()), [sweeps()], [runs()["valid_a"]])
    return SearchState.start(two_links.textbook(runs()), train, held)


def test_a_refit_to_poor_motion_does_not_run_off():
    assert np.all(rms(refitted().held_residual()) < 0.3)


def test_what_the_runs_show_does_not_move():
    state = two_links.state_of(runs())
    free = state.copy()
    free.problem = replace(free.problem, bodies=None)
    free.refit()
    size = np.sqrt(np.diag(state.fit.covariance()))
    assert np.all(np.abs(state.fit.beta - free.fit.beta) < 0.01 * size)


def test_a_frozen_model_has_its_own_uncertainty_instead():
    assert two_links.state_of(runs(), frozen=True).problem.bodies is None


def test_motion_that_asks_for_what_was_not_seen_carries_doubt_farther():
    poor, rich = refitted(), two_links.state_of(runs())
    assert np.all(carried_farther(poor, honest_covariance(poor)) > CARRIED_FARTHER)
    assert np.all(carried_farther(rich, honest_covariance(rich)) < CARRIED_FARTHER)


@pytest.mark.long
def test_what_the_fitted_runs_leave_open_is_not_called_missing():
    """A file whose bodies are off is all that anybody knows there."""
    model = identify([sweeps()], robot_from_urdf(HEAVIER), name="m0", cutoff=two_links.CUTOFF)
    found = diagnose(model, [sweeps()], [runs()["valid_a"]])
    assert found.verdict == "none"
    told = [line.sentence for line in found.remaining if line.material]
    assert told
    assert all("do not determine the arm for this motion" in sentence for sentence in told)
