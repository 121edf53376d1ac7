"""Torque that stood at the end of its channel says nothing of the arm, and is left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from two_links import COULOMB, CUTOFF, motion, recordings, robot, textbook

from pa10d.checks import check_recording
from pa10d.compare.comparison import compare
from pa10d.diagnose.procedure import diagnose
from pa10d.judgement import judge
from pa10d.measurement.clipped import clipped
from pa10d.measurement.recording import Recording
from pa10d.measurement.spans import spans
from pa10d.regression.equation import prepare
from pa10d.regression.noisy_limits import (
    noisy_limits,
    sharing_limits,
    torque_ends,
    with_limits,
)

TOP = 22.0  # N·m of joint 1, of which the motion asks 29 to 40
NOISE = 0.05 * np.sqrt(CUTOFF / 100.0)  # N·m RMS within the band


def cut(run, top=TOP):
    """As a converter hands it on that ends at ``top`` N·m on joint 1."""
    tau = run.tau.copy()
    tau[:, 0] = np.clip(tau[:, 0], -top, top)
    return replace(run, tau=tau)


@pytest.fixture(scope="module")
def runs():
    return {name: cut(run) for name, run in recordings().items()}


@pytest.fixture(scope="module")
def model(runs):
    return textbook(runs)


def test_what_stands_at_a_limit_moves_no_number(runs, model):
    """Fitted, it made that joint's viscous friction 2.6 for 3, at 80 times the noise."""
    share = runs["fit_a"].clipped.mean(axis=0)
    assert share[0] > 0.02
    assert share[1] == 0.0
    friction = next(t for t in model.terms if t.effect_id == "coulomb" and t.joints == (0,))
    assert friction.coefficients[0] == pytest.approx(COULOMB[0], abs=0.05)
    left = judge(model, [recordings()["valid_a"]]).rms  # where nothing ends, too
    assert left == pytest.approx(NOISE, rel=0.15)


@pytest.mark.long
def test_nothing_is_missing_on_an_arm_whose_channel_ends(runs, model):
    found = diagnose(model, [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]])
    assert not found.findings
    assert found.verdict == "none"


def test_no_sample_that_counts_knows_what_a_limit_took():
    """Whatever is cut off beyond it: 1 or 1000 N·m."""
    run = recordings()["fit_a"]
    beyond = clipped(run.q, cut(run).tau)
    far = np.where(beyond, 1000.0, run.tau)
    seen = [
        prepare(replace(run, tau=tau, limited=beyond), robot(), CUTOFF, stands=False)
        for tau in (cut(run).tau, far)
    ]
    keep = seen[0].keep
    assert keep[:, 0].mean() > 0.5
    assert seen[1].driven[keep] == pytest.approx(seen[0].driven[keep], abs=1e-9)


def test_a_part_of_a_run_knows_what_the_whole_shows():
    run = cut(recordings()["fit_a"])
    begins = 1 + int(np.flatnonzero(np.diff(run.clipped[:, 0].astype(int)) > 0)[0])
    few = run.part(begins - 100, begins + 3, "")  # too few for a limit by themselves
    assert not clipped(few.q, few.tau).any()
    assert few.clipped[-3:, 0].all()


def noisily_cut(run, noise, seed, top=TOP):
    """The same limit before the noise of the sensor: no value comes twice."""
    rng = np.random.default_rng(seed)
    tau = cut(run, top).tau + noise * rng.standard_normal(run.tau.shape)
    return replace(run, tau=tau)


def test_a_limit_that_noise_hides_is_seen_by_what_the_motion_asks_for():
    """Clipped before its noise the torque was told as a spring and a gain that only some runs
    have."""
    exact = recordings(noise=0.0)["fit_a"]
    run = noisily_cut(exact, 0.05, 1)
    assert not run.clipped.any()
    at = with_limits(run, robot()).clipped
    true = np.abs(exact.tau[:, 0]) > TOP
    assert at[true, 0].mean() > 0.97
    assert at[~true, 0].mean() < 0.05
    assert not at[:, 1].any()
    said = [f for f in check_recording(run, None, robot()) if f.code == "clipped"]
    assert {(f.joint, f.severity) for f in said} == {(1, "warning")}
    assert "the motion asks for more" in said[0].sentence


def test_the_other_end_may_be_come_to_once():
    """The same torque the other way is a limit, too, though nobody could tell by itself."""
    exact = recordings(1, noise=0.0)["valid_b"]
    ((first, end),) = spans(exact.tau[:, 0] > TOP)
    at = with_limits(noisily_cut(exact, 0.05, 1), robot()).clipped[:, 0]
    assert at[first:end].mean() > 0.97


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(s, marks=pytest.mark.long) for s in range(1, 9))]
)
def test_what_is_merely_flat_is_no_limit(seed):
    """Friction that is all of a torque stands at the same two values, and sines come to their tops
    again; so does a model that lacks something there."""

    def rubbing(t, q, dq, ddq):
        more = np.column_stack([3.0 * np.abs(q[:, 0]) * np.tanh(dq[:, 0] / 0.01), 0.0 * t])
        return more

    t, q, dq, _ = motion(seed)
    twice = np.sin(2.0 * np.pi * 0.2 * t)
    only = np.column_stack([2.0 * np.sign(dq[:, 0]), 5.0 * twice])
    only += 0.02 * np.random.default_rng(seed).standard_normal(only.shape)
    assert not noisy_limits(Recording("flat", t, q, only), robot())
    for run in recordings(seed, rubbing).values():
        assert not noisy_limits(run, robot())


def proof_and_once():
    """A run that proves a limit of joint 1, one that comes to it but once, and where."""
    exact = recordings(1, noise=0.0)
    proof, whole = noisily_cut(recordings(noise=0.0)["fit_a"], 0.05, 1), exact["valid_b"]
    ((first, end),) = spans(whole.tau[:, 0] > TOP)
    near = slice(max(0, first - 800), end + 800)
    once = noisily_cut(
        Recording("once", whole.t[near] - whole.t[near][0], whole.q[near], whole.tau[near]), 0.05, 1
    )
    once.tau[:, 0] = np.maximum(once.tau[:, 0], 5.0 - TOP)  # nor is its other end come to
    return proof, once, whole.tau[near, 0] > TOP


def test_a_limit_that_one_run_proves_ends_the_others_too():
    """Come to but once in a run, its torque had made "a contact" and "friction of a place"."""
    proof, once, there = proof_and_once()
    other = recordings(4)["fit_b"]
    assert not noisy_limits(once, robot())
    _, sharing, unlike = sharing_limits([proof, once, other], robot())
    assert not noisy_limits(unlike, robot())
    assert not noisy_limits(once, robot()), "what is asked of it by itself is as before"
    (found,) = noisy_limits(sharing, robot())
    assert (found.joint, found.largest) == (0, True)
    assert found.at[there].mean() > 0.97


def test_a_model_knows_the_limits_that_its_runs_proved(model):
    """A later run alone was judged by another figure than beside them."""
    proof, once, _ = proof_and_once()
    knows = replace(model, notes=replace(model.notes, torque_ends=torque_ends([proof], robot())))
    beside, by_itself, unknown = (
        compare(made, runs).runs[-1].scores.rms
        for made, runs in ((model, [proof, once]), (knows, [once]), (model, [once]))
    )
    assert by_itself == pytest.approx(beside, rel=1e-9)
    assert unknown[0] > 1.5 * by_itself[0]


@pytest.mark.long
def test_an_identified_model_knows_them_too():
    proof, once, _ = proof_and_once()
    ends = textbook({"fit_a": proof, "fit_b": once}).notes.torque_ends
    assert {(one.joint, one.largest) for one in ends} == {(1, True), (1, False)}
    assert [abs(one.level) for one in ends] == pytest.approx([TOP, TOP], abs=0.1)
