"""Every joint that the one judgement finds above its noise is told, and no other."""

from __future__ import annotations

from dataclasses import replace

import compare_arm as arm
import numpy as np
import pytest

from pa10d.compare import compare, document
from pa10d.compare.places import failing
from pa10d.judgement import MATERIAL

PERIOD = 8.0


def follows_nothing(t, q, dq):
    """The same every period, and in no quantity's place: white within the band."""
    samples = round(PERIOD * arm.RATE)
    series = np.random.default_rng(5).standard_normal(samples)
    return arm.on_joint(1, 0.9 * np.resize(series, len(t)))


def bump(t, q, dq):
    return arm.on_joint(2, np.exp(-(((q[:, 2] - np.median(q[:, 2])) / 0.1) ** 2)))


@pytest.fixture(scope="module", params=[None, follows_nothing, bump], ids=["clean", "even", "bump"])
def said(request):
    run = arm.recording(4, 40.0, 0.3, extra=request.param, period=PERIOD)
    return request.param, document(compare(arm.model(), [run]))


def test_where_it_fails_are_the_joints_that_fail(said):
    hidden, found = said
    pooled = found["pooled"]
    ratio = np.array(pooled["rms"]) / np.array(pooled["noise_floor"])
    told = {place["joint"] for place in found["where"]}
    told |= {j for j in (1, 2, 3) if any(f"Joint {j} keeps" in s for s in pooled["spread"])}
    assert told == {j + 1 for j in np.flatnonzero(ratio > MATERIAL)}
    assert (2 if hidden is follows_nothing else 3) in told or hidden is None


def test_an_error_in_no_place_is_told_with_its_size(said):
    hidden, found = said
    if hidden is follows_nothing and not found["where"]:
        assert "times its noise floor" in found["pooled"]["spread"][0]
    if hidden is None:
        assert found["pooled"]["spread"] == []


def test_joints_of_unknown_noise_are_told_together():
    judged = compare(arm.model(), [arm.recording(4, 40.0, 0.3, period=PERIOD)]).pooled
    nothing = np.full(3, np.nan)
    own = judged.scores.rms
    (sentence,) = failing(judged.scores, nothing, arm.ROBOT, [], [], own)
    assert "on joints 1 to 3" in sentence
    assert failing(judged.scores, judged.noise_floor, arm.ROBOT, [], [], own) == []
    more, rest = failing(judged.scores, nothing, arm.ROBOT, [], [], own / [1.0, 4.0, 3.0])
    assert "on joints 2 and 3, which keep 4 and 3 times what the model leaves on the runs" in more
    assert "on joint 1, and the noise there is not known" in rest


def test_a_run_that_was_fitted_is_no_judge():
    run = arm.recording(4, 12.0, 0.3, name="seen")
    unseen, seen = arm.model(), replace(arm.model(), runs=("seen", "other"))
    assert not any("was fitted to" in said for said in compare(unseen, [run]).warnings)
    (said,) = [said for said in compare(seen, [run]).warnings if "was fitted to" in said]
    assert said.startswith("the model was fitted to seen: ")
