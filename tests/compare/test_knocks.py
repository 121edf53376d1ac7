"""Errors of a few moments are told from those of all the time."""

from types import SimpleNamespace

import compare_arm as arm
import numpy as np
import pytest

from pa10d.compare import compare, places, run_residual
from pa10d.compare.knocks import FEWEST, STRETCH, Knocks, _after_rests, few_moments, knocks
from pa10d.compare.phrases import sentence
from pa10d.compare.quantities import Quantity
from pa10d.compare.regions import Region

SECONDS = 30.0
WHEN = (4.1, 9.7, 15.2, 21.3, 26.6)


def bumped(t, q, dq):
    """15 N·m for 0.15 s, five times, wherever joint 2 is."""
    there = sum((t >= at) & (t < at + 0.15) for at in WHEN)
    return arm.on_joint(1, 15.0 * there)


def recorded(extra, seed=1):
    return arm.recording(seed, SECONDS, 0.2, extra)


def test_knocks_are_told_with_the_moment_and_what_to_do():
    run = run_residual(arm.model(), recorded(bumped))
    found = knocks([run], 1)
    assert found.share > 0.8
    assert found.seconds < 0.1 * found.of
    assert min(abs(found.at - at) for at in WHEN) <= STRETCH + 0.15
    assert knocks([run], 0) is None
    (said,) = compare(arm.model(), [recorded(bumped)]).runs[0].spread
    assert said.startswith("Joint 2 keeps ")
    assert found.words in said
    assert "--robust" in said


def test_what_acts_in_a_few_moments_by_the_motion_is_found_there():
    def contact(t, q, dq):
        return arm.on_joint(2, 200.0 * np.maximum(0.0, q[:, 2] - 0.8))

    run = run_residual(arm.model(), arm.recording(2, 60.0, 0.2, contact))
    assert few_moments([(run.error[:, 2], run.judged[:, 2], run.equation.rate)]) is not None
    assert next(p.variable for p in places([run], arm.ROBOT) if p.joint == 2) == "q3"


@pytest.mark.parametrize(("late", "told"), [(0.1, True), (1.4, False)])
def test_what_comes_where_the_joint_moves_on_after_a_rest_is_told_as_that(late, told):
    """ "A knock, a hand" was said of friction that grows at rest: strokes of 2 s, rests of 1 s."""
    t = np.arange(0.0, 60.0, 0.02)
    since = t % 3.0 - 1.0  # s since it moved on
    speed = np.where(since > 0.0, np.sin(np.pi * np.clip(since, 0.0, 2.0) / 2.0), 0.0)
    error = np.where((since > late) & (since < late + 0.15) & (t // 3.0 % 3.0 == 0.0), 4.0, 0.05)
    found = few_moments([(error, since > 0.05, 50.0)])
    run = SimpleNamespace(
        seen=SimpleNamespace(dq=speed[:, None], dt=0.02),
        error=error[:, None],
        judged=(since > 0.05)[:, None],
        equation=SimpleNamespace(rate=50.0),
        decimated=lambda values: values,
    )
    assert _after_rests([run], 0, found) == told
    words = Knocks(found.share, found.seconds, 40.0, "r", 4.0, told).words
    assert ("after it has stood" in words) == told
    assert ("a knock" in words) != told


@pytest.mark.parametrize(("before", "told"), [(0.0, True), (4.0, False)])
def test_what_comes_as_much_before_a_rest_is_no_matter_of_having_stood(before, told):
    """ "A brake that lets go late" was said of Stribeck friction whose corner was too sharp."""
    t = np.arange(0.0, 60.0, 0.02)
    since = (t - 1.72) % 3.0  # s since it moved on from a rest of 0.1 s
    speed = np.where(since < 2.9, np.sin(np.pi * since / 2.9), 0.0)
    there = t // 3.0 % 5.0 == 2.0
    error = np.where((since < 0.12) & there, 4.0, 0.05)
    error = np.where((since > 2.78) & (since < 2.9) & there, before, error)
    judged = speed > 0.0
    found = few_moments([(error, judged, 50.0)])
    run = SimpleNamespace(
        seen=SimpleNamespace(dq=speed[:, None], dt=0.02),
        error=error[:, None],
        judged=judged[:, None],
        equation=SimpleNamespace(rate=50.0),
        decimated=lambda values: values,
    )
    assert _after_rests([run], 0, found) == told


@pytest.mark.parametrize(("after", "told"), [(0.0, True), (0.9, False)])
def test_what_comes_where_a_joint_hardly_moves_is_no_knock(after, told):
    """Dry friction with too soft a corner, seen where a joint turns round now and then; "a knock, a
    hand" was said of it. The same a little later in the swing is nobody's friction."""
    t = np.arange(0.0, 60.0, 0.02)
    speed = np.sin(np.pi * t / 3.0)
    there = [np.abs(t - at - after) < 0.07 for at in (6.0, 15.0, 24.0, 39.0)]
    error = np.where(np.any(there, axis=0), 4.0, 0.05)
    run = SimpleNamespace(
        name="r",
        rested=(),
        judged=np.ones((len(t), 1), dtype=bool),
        error=error[:, None],
        seen=SimpleNamespace(dq=speed[:, None], dt=0.02),
        equation=SimpleNamespace(rate=50.0),
        model=SimpleNamespace(robot=arm.ROBOT),
        decimated=lambda values: values,
    )
    words = knocks([run], 0).words
    assert ("slower than 0.16 rad/s" in words) == told
    assert ("a knock" in words) != told


@pytest.mark.parametrize("lasting", [0.0, 0.3, 1.0])
def test_noise_of_any_colour_is_no_knock(lasting):
    """AR(1), in memory up to the length of four stretches."""

    def slow(t, q, dq):
        rng = np.random.default_rng(3)
        kept = np.exp(-(t[1] - t[0]) / lasting) if lasting else 0.0
        noise, white = np.zeros(len(t)), rng.standard_normal(len(t))
        for k in range(1, len(t)):
            noise[k] = kept * noise[k - 1] + white[k]
        return arm.on_joint(1, 2.0 * noise / noise.std())

    run = run_residual(arm.model(), recorded(slow))
    assert np.sum(run.judged[:, 1]) > FEWEST
    assert knocks([run], 1) is None


def test_the_rounding_of_a_zero_is_told_as_zero():
    region = Region(Quantity("dq", 0, "rad/s", False), -0.042, -5.7e-17, False, False, 0.9, 0.1)
    assert "between -0.042 and 0 rad/s" in sentence(1, region, "N·m")
