"""A doubt, and the experiment that settles it: a request the experiments accept as it stands."""

from __future__ import annotations

import shlex
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from two_links import recordings, robot, textbook

from pa10d.cli.daemon_client import read_plan
from pa10d.diagnose.outcome.next_experiment import requests, settle_doubt
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.diagnose.search.candidates import Candidate
from pa10d.effects import effect
from pa10d.trajectory.kinds import KINDS, validated
from pa10d.trajectory.poses import Surroundings


@pytest.fixture(scope="module")
def model():
    return textbook(recordings(1))


def candidate(name: str, joint: int, theta: list[float], **shape: float) -> Candidate:
    return Candidate(effect(name), (joint,), shape, SimpleNamespace(theta=np.array(theta)))  # type: ignore[arg-type]


def test_an_offset_and_a_spring_are_told_apart_by_moving_farther(model):
    """Seen over a short range only, both pull alike."""
    offset = candidate("torque_offset", 1, [0.5])
    spring = candidate("spring", 1, [0.02, -0.5])
    plan = settle_doubt(model, spring, [offset])
    if plan is None:
        pytest.fail("no experiment would tell 0.5 N·m of offset from a spring")
    assert plan.kind in KINDS
    assert plan.apart >= 3.0
    built = validated(KINDS[plan.kind], plan.parameters).build(Surroundings.of(robot()))
    moved = built.sample(50.0)
    assert np.all(np.abs(moved.q) <= robot().upper + 1e-9)


@pytest.mark.long
def test_a_finding_that_is_in_the_model_already_is_asked_about_as_if_it_were_not(model):
    """The diagnosis asks after it has added the finding."""
    offset = candidate("torque_offset", 1, [0.5])
    spring = candidate("spring", 1, [0.02, -0.5])
    grown = replace(model, terms=(*model.terms, spring.term))
    assert settle_doubt(grown, spring, [offset]) == settle_doubt(model, spring, [offset])


@pytest.mark.long
def test_stribeck_and_presliding_get_an_experiment_of_their_joint(model):
    first = candidate("stribeck", 0, [1.0], vs=0.05, delta=1.0)
    second = candidate("presliding_hysteresis", 0, [1.0], zs=0.01)
    plan = settle_doubt(model, first, [second])
    assert plan is not None
    asked = requests(model, first, [second])
    assert {k.request()["kind"] for k in asked} >= {"velocity_sweep", "reversals"}


def test_the_same_torque_twice_cannot_be_settled(model):
    one = candidate("torque_offset", 1, [0.5])
    assert settle_doubt(model, one, [one]) is None


@pytest.mark.long
def test_an_effect_far_below_the_noise_is_not_worth_an_experiment(model):
    one = candidate("torque_offset", 1, [1e-6])
    other = candidate("spring", 1, [1e-6, 0.0])
    assert settle_doubt(model, one, [other]) is None


@pytest.mark.parametrize(
    "given", [{}, {"joints": [4, 5]}, {"pose": [0.1, -2.0], "name": "it's odd", "slow": True}]
)
def test_a_plan_is_told_as_the_command_that_runs_it(given):
    plan = NextExperiment("velocity_sweep", given, apart=9.0)
    program, verb, kind, *rest = shlex.split(plan.command)
    assert (program, verb) == ("pa10d", "experiment")
    assert read_plan(kind, None, rest[1:]) == {"kind": kind, "parameters": given}


def test_what_is_written_into_a_file_is_read_as_it_was():
    asked = {"kind": "chirp", "parameters": {"joints": [4]}}
    told = {**asked, "about": {"expected_standard_errors": 9.0}}
    plan = NextExperiment.read(told)
    assert plan.document() == told
    assert plan.apart == 9.0
    assert NextExperiment.read(asked).document() == asked
    assert NextExperiment.read(asked) == plan, "the same motion, whatever is expected of it"
