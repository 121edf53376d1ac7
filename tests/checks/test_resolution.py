"""What is renewed too seldom, written with too few digits, or stamped in no seconds is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from one_ur5e import recorded, ur5e

from pa10d.checks.resolution import check_resolution, level_of, renewed_every
from pa10d.checks.units import check_speeds

RNG = np.random.default_rng(4)


@pytest.fixture(scope="module")
def clean():
    return recorded(15.0)


def _said(run):
    return [(f.code, f.joint) for f in check_resolution(run, ur5e())]


def test_a_sound_recording_is_silent(clean):
    assert _said(clean) == []
    assert list(check_speeds(clean, ur5e())) == []


@pytest.mark.parametrize("every", [2, 5, 10])
def test_a_slow_channel_is_told_its_rate(clean, every):
    held = clean.q[np.arange(len(clean.t)) // every * every]
    (found,) = check_resolution(replace(clean, q=held), ur5e())
    assert found.code == "seldom"
    assert f"every {every}th sample only ({clean.rate / every:.4g} Hz)" in found.sentence
    tau = clean.tau[np.arange(len(clean.t)) // every * every]
    (found,) = check_resolution(replace(clean, tau=tau), ur5e())
    assert "tau is new" in found.sentence


def test_positions_of_two_decimals(clean):
    (found,) = check_resolution(replace(clean, q=np.round(clean.q, 2)), ur5e())
    assert found.code == "rounded"
    assert "steps of 0.01 rad" in found.sentence
    assert _said(replace(clean, q=np.round(clean.q, 4))) == []


def test_an_encoder_keeps_no_rhythm():
    t = np.arange(4000) / 200.0
    counts = np.round(0.4 * np.sin(t) * 4096 / (2 * np.pi))
    assert renewed_every(counts) is None
    assert renewed_every(np.where(RNG.uniform(size=4000) < 0.1, 1.0, 0.0).cumsum()) is None
    assert level_of(RNG.normal(size=4000)) == 0.0


def test_stamps_that_are_no_seconds_make_joints_too_fast(clean):
    minutes = replace(clean, t=clean.t / 60.0)
    (found,) = check_speeds(minutes, ur5e())
    assert (found.code, found.severity) == ("time_unit", "error")
    assert "[min]" in found.advice
