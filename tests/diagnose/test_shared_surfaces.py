"""What two joints share sticks where their speeds cancel, though each of them moves."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from sticking import motion
from two_links import CUTOFF, NAMES, robot, textbook, textbook_torque

from pa10d.diagnose.asked.one_effect import add
from pa10d.judgement import first_and_last, judge, run_residual
from pa10d.measurement.recording import Recording
from pa10d.model import Term
from pa10d.regression.equation import prepare
from pa10d.regression.shared_surfaces import sharing, where_shared_slips

F = 3.0  # N·m
SHARED = Term("coupling_friction", (0, 1), np.array([F, 0.0]), {"ratio": 1.0, "viscous": 0.0})


@cache
def runs():
    """Of two joints whose speeds' sum truly sticks, for some 10 to 60 ms at a time, while both
    turn on: meanwhile its friction goes from one breakaway to the other."""
    out = {}
    for number, name in enumerate(NAMES):
        rng = np.random.default_rng([4, number])
        t, *moved, way, stands = motion(400 + number)
        q, dq, ddq = (np.column_stack([x.sum(axis=1), x @ [1.0, -1.0]]) / 2.0 for x in moved)
        shared = F * np.where(stands[:, 0], way[:, 0], np.sign(moved[1][:, 0]))
        tau = textbook_torque(q, dq, ddq) + shared[:, None]
        tau += 0.05 * rng.standard_normal(tau.shape)
        out[name] = Recording(name, t[::2], q[::2], tau[::2])
    return out


@cache
def added():
    """The version with coupled friction, fitted and judged by other runs."""
    fit, judged = ([runs()[f"{side}_{k}"] for k in "ab"] for side in ("fit", "valid"))
    return add(textbook(runs()), "coupling_friction", (0, 1), fit, name="m1", validate=judged)[0]


def test_moments_in_which_it_sticks_are_out_of_fit_and_judgement():
    """They made a sure finding keep 12.9 times its noise."""
    model = added()
    told = model.term_values(len(model.terms) - 1)["F"]
    assert abs(told.value - F) < 2.0 * told.std_error < 0.2 * F
    noise = judge(model, [runs()["valid_a"], runs()["valid_b"]]).floor.values
    assert np.all(np.array(model.notes.delivery.achieved) < 1.1 * noise)


def test_promise_and_delivery_and_whoever_asks_later_have_the_same_samples():
    told = added().notes.delivery
    later = judge(added(), [runs()["valid_a"], runs()["valid_b"]])
    assert told.achieved == pytest.approx(later.rms, rel=1e-9)
    assert told.promised == pytest.approx(told.achieved, rel=0.1)
    assert "joints 1 and 2 where what they share slips" in told.mask == later.mask
    before = judge(textbook(runs()), [runs()["valid_a"]])
    assert "share" not in before.mask, "it shares nothing"


def test_a_model_without_shared_surfaces_is_judged_as_ever():
    seen = run_residual(textbook(runs()), runs()["valid_a"])
    assert seen.sharing == ()
    plain = prepare(runs()["valid_a"], robot(), CUTOFF, stands=False)
    assert where_shared_slips(plain, added().terms[:-1]) is plain
    assert sharing(plain, added().terms) == (0, 1)


def test_asked_again_nothing_changes_and_only_those_that_share_are_touched():
    plain = prepare(runs()["valid_a"], robot(), CUTOFF, stands=False)
    once = where_shared_slips(plain, [SHARED])
    again = where_shared_slips(once, [SHARED])
    assert again is once
    assert np.all(once.going <= plain.going)
    assert 0.5 < once.keep.sum() / plain.keep.sum() < 1.0


def test_a_joint_that_would_keep_nothing_is_left_as_it_is():
    """Both turn to and fro as one, against each other: what they share never slips."""
    run = runs()["valid_a"]
    run = replace(run, q=np.column_stack([run.q[:, 0], -run.q[:, 0]]))
    plain = prepare(run, robot(), CUTOFF, stands=False)
    left = where_shared_slips(plain, [SHARED])
    assert np.array_equal(left.keep, plain.keep)
    assert np.array_equal(left.going, plain.going)


def test_samples_of_the_versions_before_are_named_where_they_are_others():
    """ "All judged on … where what they share slips" was said of versions that share nothing."""
    run = [runs()["valid_a"]]
    before, after = judge(textbook(runs()), run), judge(added(), run)
    told = first_and_last(before, after)
    assert told == f"{after.mask} (before that was found: {before.mask})"
    assert first_and_last(after, after) == after.mask
