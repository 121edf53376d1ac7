"""One common timing offset is taken out; what belongs to one joint stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from two_links import recordings, state_of, textbook

from pa10d.diagnose.search import timing
from pa10d.diagnose.search.timing import align, joint_delays, shared, weighted_median
from pa10d.measurement.signals import delayed

finite = st.floats(-10, 10)


@given(st.lists(st.tuples(finite, st.floats(0.5, 2.0)), min_size=5, max_size=9))
def test_weighted_median_is_the_point_of_least_weighted_distance(pairs):
    values, errors = np.array(pairs).T
    found, error = weighted_median(values, errors)
    weight = 1.0 / errors  # alike enough for none to reach a third
    if np.max(weight) / weight.sum() >= 1.0 / 3.0:
        return

    def distance(x):
        return float(np.sum(weight * np.abs(values - x)))

    assert distance(found) <= min(distance(v) for v in values) + 1e-9
    assert error > 0


def test_no_joint_alone_moves_the_median():
    values = np.array([5.0, 0.0, 0.1, -0.1])
    errors = np.array([1e-9, 1.0, 1.0, 1.0])
    assert abs(weighted_median(values, errors)[0]) < 0.2


def test_a_joint_known_far_better_than_the_others_does_not_speak_for_them():
    delays = np.array([2e-3, 0.0, 1e-5, -1e-5, 0.0])
    errors = np.array([1e-9, 1e-4, 1e-4, 1e-4, 1e-4])
    assert not shared(weighted_median(delays, errors)[0], delays, errors)


def test_median_of_nothing_known_is_zero_and_worthless():
    assert weighted_median(np.ones(3), np.full(3, np.inf)) == (0.0, np.inf)


def test_its_error_is_that_of_a_median():
    rng = np.random.default_rng(1)
    errors = np.full(101, 0.5)
    found = [weighted_median(errors * rng.standard_normal(101), errors) for _ in range(400)]
    claimed = found[0][1]
    assert np.std([f[0] for f in found]) == pytest.approx(claimed, rel=0.15)


def test_joints_that_disagree_share_no_offset():
    errors = np.full(4, 1e-5)
    assert shared(1e-3, np.full(4, 1e-3), errors)
    assert not shared(1e-3, np.array([1e-3, 1e-3, -2e-3, 5e-3]), errors)


def test_who_may_as_well_say_nothing_is_no_witness_of_an_offset():
    """Seven joints of an arm without any, presliding friction in one of them not yet named: half of
    the joints, by weight, say 0.3 ms, the others nothing or the contrary."""
    delays = 1e-3 * np.array([0.489, -0.287, -0.334, 3.749, -0.267, -0.011, 0.233])
    errors = 1e-3 * np.array([0.107, 0.297, 0.103, 1.889, 0.108, 0.113, 0.478])
    offset, error = weighted_median(delays, errors)
    assert offset < -3.0 * error, "noise alone does not make it"
    assert not shared(offset, delays, errors)
    rng = np.random.default_rng(2)
    assert shared(-1e-3, -1e-3 + errors * rng.standard_normal(7), errors)


def late(runs, seconds, joints=(0, 1)):
    """The same runs with the torque of some joints late."""
    out = {}
    for name, run in runs.items():
        tau = run.tau.copy()
        moved = delayed(run.tau, seconds, run.rate)
        tau[:, list(joints)] = moved[:, list(joints)]
        out[name] = replace(run, tau=tau)
    return out


@pytest.mark.by_default("0.002")
@pytest.mark.parametrize("seconds", [2e-3, -1.5e-3])
def test_a_common_offset_is_found_and_taken_out(seconds):
    clean = recordings(1, noise=0.005)
    model, runs = textbook(clean), late(clean, seconds)
    state = state_of(runs, model)
    before = state.fit.rms()
    assert align(state) == pytest.approx(seconds, abs=3e-5)
    assert np.all(state.fit.rms() < before)
    assert state.fit.rms() == pytest.approx(state_of(clean, model).fit.rms(), rel=0.05)
    assert [run.shift for run in state.held.runs] == pytest.approx([seconds] * 2, abs=1e-4)


@pytest.mark.by_default("joints1-0.0")
@pytest.mark.parametrize(("joints", "taken"), [((0, 1), 2e-3), ((1,), 0.0), ((), 0.0)])
def test_an_offset_that_helps_every_joint_is_taken_though_they_contradict(
    joints, taken, monkeypatch
):
    """A gap on one joint bent the bodies that all share, and two others were "measured late" by
    1.6 ms each: joints that contradict each other were not asked what an offset does to them."""
    said, sure = np.array([1e-3, 3e-3]), np.full(2, 1e-5)
    assert not shared(weighted_median(said, sure)[0], said, sure)
    clean = recordings(1, noise=0.005)
    state = state_of(late(clean, 2e-3, joints) if joints else clean, textbook(clean))
    monkeypatch.setattr(timing, "joint_delays", lambda state: (said, sure))
    assert align(state) == 0.0, "as long as nobody is said to be late"
    assert align(state, contradicting=True) == pytest.approx(taken, abs=1e-9)


def test_aligned_runs_stay_where_they_are():
    assert align(state_of(recordings(2, noise=0.005))) == pytest.approx(0.0, abs=3e-5)


def test_the_delay_of_one_joint_is_seen_there_and_left():
    clean = recordings(1)
    state = state_of(late(clean, 5e-3, joints=(1,)), textbook(clean))
    delays, errors = joint_delays(state)
    assert delays[1] == pytest.approx(5e-3, rel=0.2)
    assert abs(delays[0]) < 1e-3
    assert errors[1] < 1e-3
    assert abs(align(state)) < 1e-3


def answered(runs, step):
    """The same runs as a servo of 3 Hz reads them by an encoder of this noise, and answers."""
    out, inertia, servo = {}, np.array([1.2, 0.3]), 2 * np.pi * 3.0
    for name, run in runs.items():
        noise = step * np.random.default_rng(len(name)).standard_normal(run.q.shape)
        moved = np.diff(noise, axis=0, prepend=noise[:1]) * run.rate
        answer = -inertia * servo * (servo * noise + 1.4 * moved)
        out[name] = replace(run, q=run.q + noise, tau=run.tau + answer)
    return out


def test_what_a_servo_answers_to_its_encoder_is_no_delay():
    """The whole band says -3.6 ± 0.3 and -0.6 ± 0.1 ms."""
    clean = recordings(1, noise=0.005)
    delays, errors = joint_delays(state_of(answered(clean, 5e-4), textbook(clean)))
    assert np.all(np.abs(delays) < 1.2e-3)
    assert np.all(errors < 5e-4)
