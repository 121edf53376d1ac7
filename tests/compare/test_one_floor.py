"""Noise is a property of the runs: whoever judges them has one floor."""

from __future__ import annotations

import sys
from dataclasses import replace

import compare_arm as arm
import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.compare import compare
from pa10d.judgement import NoiseFloor, beside_its_own, judge, judge_alike, least_floor, one_floor
from pa10d.model import Term

WARM = 20.0  # s


def test_the_least_is_taken_joint_by_joint_with_how_it_was_found():
    poor = NoiseFloor(np.array([0.9, 0.2, np.nan]), ("a", "b", None), np.full(3, 0.1), np.ones(3))
    good = NoiseFloor(np.array([0.5, np.nan, np.nan]), ("c", None, None), np.zeros(3), np.zeros(3))
    found = least_floor([poor, good])
    np.testing.assert_array_equal(found.values, [0.5, 0.2, np.nan])
    assert found.methods == ("c", "b", None)
    np.testing.assert_array_equal(found.errors[:2], [0.0, 0.1])
    np.testing.assert_array_equal(found.slow[:2], [0.0, 1.0])


def test_what_a_model_makes_of_the_angles_noise_is_its_own():
    """One model on one run kept 1.9 times its floor in `improve`, and 4.2 times in `compare`."""
    rigid = NoiseFloor(np.array([0.018, 0.3]), ("high frequencies",) * 2, np.zeros(2), np.ones(2))
    spring = NoiseFloor(
        np.array([0.039, 0.4]), ("the angles' noise", "high frequencies"), np.ones(2), np.zeros(2)
    )
    found = beside_its_own(least_floor([rigid, spring]), spring)
    np.testing.assert_array_equal(found.values, [0.039, 0.3])
    assert found.methods == spring.methods
    np.testing.assert_array_equal(found.errors, [1.0, 0.0])
    alone = beside_its_own(least_floor([rigid, spring]), rigid)
    np.testing.assert_array_equal(alone.values, rigid.values)


def warming(t, q, dq):
    """Never comes again, though the motion does: through a model without it, that is noise."""
    return -4.0 * (1.0 - np.exp(-t / WARM))[:, None] * dq


@pytest.fixture(scope="module")
def poor():
    return arm.model()


@pytest.fixture(scope="module")
def good(poor):
    shape = {"T": WARM, "heated": 0.0}
    warm = [Term("thermal_friction", (j,), np.array([4.0, 0.0]), shape) for j in range(3)]
    return replace(poor, name="good", terms=(*poor.terms, *warm))


@pytest.fixture(scope="module")
def runs():
    return [arm.recording(k, 12.0, 0.2, warming, period=4.0, name=f"run {k}") for k in (1, 2)]


@pytest.mark.long
def test_a_poor_model_is_judged_by_the_noise_that_a_good_one_shows(good, poor, runs):
    alone, together = judge(poor, runs), compare(poor, runs, beside=[good])
    floor = judge(good, runs).floor.values
    assert (alone.floor.values > 1.2 * floor).all()
    np.testing.assert_allclose(together.pooled.noise_floor, floor)
    np.testing.assert_allclose(together.pooled.scores.rms, alone.rms)
    for one, run in zip(together.runs, runs, strict=True):
        np.testing.assert_allclose(one.noise_floor, judge(good, [run]).floor.values)
    np.testing.assert_allclose(together.beside[0].rms, judge(good, runs).rms)
    for one in judge_alike([poor, good], runs):
        np.testing.assert_allclose(one.floor.values, floor)
    (only,) = judge_alike([poor], runs, beside=[good])
    np.testing.assert_allclose(only.floor.values, floor)


def test_a_model_that_cannot_see_the_runs_shows_nothing(good, runs, monkeypatch):
    """As one with an effect that asks for a temperature, which these runs do not have."""

    def refuse(*_):
        raise UserError("these runs have no temperature")

    blind = replace(good, name="blind")
    monkeypatch.setattr(one_floor, "in_band", refuse)
    found = compare(good, runs, beside=[blind])
    assert found.beside == (None,)
    np.testing.assert_allclose(found.pooled.noise_floor, judge(good, runs).floor.values)
    (same,) = judge_alike([good], runs, beside=[blind])
    np.testing.assert_allclose(same.floor.values, found.pooled.noise_floor)


def test_a_floor_that_runs_do_not_show_is_that_of_the_models_own_runs():
    """One and the same sensor was "not known" here and known there."""
    seen = NoiseFloor(np.array([0.5, np.nan, np.nan]), ("c", None, None), np.ones(3), np.ones(3))
    rms = np.array([0.6, 0.3, 0.05])
    found = one_floor.or_of_own_runs(seen, np.array([0.4, 0.2, 0.2]), rms)
    np.testing.assert_array_equal(found.values, [0.5, 0.2, np.nan])
    assert found.methods == ("c", "the model's own runs", None)
    assert (found.slow[0], found.slow[1]) == (1.0, np.inf)
    assert one_floor.or_of_own_runs(seen, None, rms) is seen


def test_a_comparison_and_a_judgement_take_it_in_the_same_band_alone(poor, runs, monkeypatch):
    known = replace(poor, notes=replace(poor.notes, noise_floor=(0.01, 0.01, 0.01)))
    blind = NoiseFloor(np.full(3, np.nan), (None,) * 3, np.full(3, np.nan), np.full(3, np.inf))
    monkeypatch.setattr(sys.modules["pa10d.judgement.judge"], "noise_floor", lambda runs: blind)
    for cutoff, told in ((known.cutoff, True), (0.5 * known.cutoff, False)):
        for floor in (
            judge(known, runs, cutoff).floor,
            compare(known, runs, cutoff=cutoff).pooled.floor,
        ):
            assert bool(np.all(np.isfinite(floor.values))) is told
