"""Cuts around standstills reach as far as the filter rings, and leave some of the motion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pa10d.measurement.signals import Lowpass
from pa10d.measurement.standstill import NARROWER, REACH, held, near, standstill

RATE, CUTOFF = 500.0, 12.5


def cut(hertz: float, **options) -> np.ndarray:
    """(M,) of a joint that swings."""
    t = np.arange(round(8 * RATE)) / RATE
    lowpass = Lowpass(len(t), RATE, CUTOFF)
    return standstill(np.cos(2 * np.pi * hertz * t)[:, None], RATE, lowpass, **options)[:, 0]


@pytest.mark.parametrize(("hertz", "reach"), [(0.5, REACH), (4.0, NARROWER[1][0])])
def test_how_far_a_cut_reaches_follows_from_how_often_a_joint_turns_round(hertz, reach):
    share = 2 * hertz * 2 * reach / CUTOFF
    assert cut(hertz).mean() == pytest.approx(share, rel=0.15)
    assert cut(hertz, wider=2.0).mean() > 1.5 * cut(hertz).mean()


def test_a_joint_that_only_trembles_is_not_left_out_altogether():
    assert cut(40.0).mean() < 0.2  # the instants themselves


def test_a_joint_that_gives_way_to_the_others_is_held():
    travel = np.array([2.0, 1e-3, 0.1, 1e-3, 0.05e-3])
    q = travel * np.sin(np.linspace(0.0, 9.0, 500))[:, None]
    found = held(q, ["N·m", "N·m", "N·m", "N", "N"])
    assert found.tolist() == [False, True, False, False, False]
    assert not held(np.zeros((9, 2)), ["N·m", "N·m"]).any(), "nobody travels: nothing is known"


def test_a_rest_is_left_out_as_far_as_the_filter_reaches():
    t = np.arange(round(8 * RATE)) / RATE
    dq = np.where((t > 3.0) & (t < 5.0), 0.0, 1.0)[:, None]
    found = standstill(dq, RATE, Lowpass(len(t), RATE, CUTOFF))[:, 0]
    reach = REACH / CUTOFF
    assert t[found].min() == pytest.approx(3.0 - reach, abs=2.5 / RATE)
    assert t[found].max() == pytest.approx(5.0 + reach, abs=2.5 / RATE)


def test_the_main_lobe_of_the_filter_ends_where_the_narrower_cut_does():
    """What reaches farther is at most a seventh of the peak."""
    samples = 4001
    impulse = np.zeros(samples)
    impulse[samples // 2] = 1.0
    answer = Lowpass(samples, RATE, CUTOFF)(impulse)
    lag = np.abs(np.arange(samples) - samples // 2) / RATE * CUTOFF
    assert np.abs(answer[lag > NARROWER[1][0]]).max() < answer.max() / 7.0
    assert np.abs(answer[lag > REACH]).max() < answer.max() / 9.0
    assert answer[lag < 0.45].min() > 0.0


@settings(max_examples=50)
@given(st.lists(st.integers(0, 99), max_size=6), st.integers(0, 30))
def test_near_is_what_lies_within_reach(starts, reach):
    stops = np.array([(s, s + 1) for s in starts], dtype=np.int64).reshape(-1, 2)
    expected = [any(s - reach <= k < s + 1 + reach for s in starts) for k in range(100)]
    assert near(stops, 100, reach).tolist() == expected
