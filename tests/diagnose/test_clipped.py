"""Torque that stood at the end of its channel says nothing of the arm, and is left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from two_links import COULOMB, CUTOFF, recordings, robot, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.judgement import judge
from pa10d.measurement.clipped import clipped
from pa10d.regression.equation import prepare

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
