"""Stamps that scatter: the positions tell whether the samples were read so."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pa10d
from pa10d.measurement.scattered_stamps import evened, found_in_positions

RATE = 250.0


def position(t):
    """(N, 2) rad."""
    return np.stack([np.sin(1.7 * t) + 0.3 * np.sin(5.1 * t), 0.6 * np.cos(2.3 * t)], axis=1)


def stamps(seed, scatter, count=4000, missing=0):
    """Equal steps (N,) s of which some are missing, and stamps that scatter about them."""
    rng = np.random.default_rng(seed)
    kept = np.sort(rng.choice(count, count - missing, replace=False))
    even = kept / RATE
    return even, even + rng.uniform(-scatter, scatter, len(even)) / RATE


@pytest.mark.long
@given(st.integers(0, 10_000), st.floats(0.02, 0.35), st.integers(0, 40), st.floats(1e-7, 3e-4))
@settings(max_examples=4, deadline=None)
def test_samples_read_at_equal_steps_are_put_there(seed, scatter, missing, noise):
    """Or left alone, where the encoder is too coarse to tell; never by more than a step's hundredth
    beside where they were read."""
    even, stamped = stamps(seed, scatter, missing=missing)
    q = position(even) + noise * np.random.default_rng(seed).standard_normal((len(even), 2))
    found = evened(stamped, q)
    if found is None:
        assert noise > 3e-4 * scatter
    else:
        assert np.abs(found - even).max() < 0.1 * scatter / RATE


@pytest.mark.long
@given(st.integers(0, 10_000), st.floats(0.02, 0.35), st.integers(0, 40), st.floats(1e-7, 1e-2))
@settings(max_examples=4, deadline=None)
def test_samples_read_late_keep_their_stamps(seed, scatter, missing, noise):
    _, stamped = stamps(seed, scatter, missing=missing)
    q = position(stamped) + noise * np.random.default_rng(seed).standard_normal((len(stamped), 2))
    assert evened(stamped, q) is None


def test_the_share_that_is_found_is_the_share_that_is_there():
    even, stamped = stamps(1, 0.3)
    late = (stamped - even) * RATE
    noise = 1e-5 * np.random.default_rng(2).standard_normal((len(even), 2))
    for share in (0.0, 0.3, 1.0):
        q = position(even + share * late / RATE) + noise
        found, error = found_in_positions(q, np.arange(len(even)), late)
        assert abs(found - share) < 4.0 * error + 0.01
        assert error < 0.02


def test_an_arm_at_rest_cannot_tell():
    even, stamped = stamps(1, 0.3)
    assert evened(stamped, np.zeros((len(even), 2))) is None


@pytest.mark.parametrize("missing", [0, 20])
def test_a_run_is_set_right(missing):
    even, stamped = stamps(3, 0.15, missing=missing)
    q = position(even)
    run = pa10d.Run(stamped, q, q)
    inner = slice(5, -5)
    off = np.abs(run.q - position(run.time))[inner]
    assert off.max() < 1e-4, "as read late by 0.6 ms at 3 rad/s it would be 20 times that"


def bursts(count=4000, packet=4):
    """Equal steps (N,) s, and when packets of several samples arrive: these come at once."""
    even = np.arange(count) / RATE
    arrival = even[packet - 1 :: packet].repeat(packet) + np.tile(np.arange(packet) * 2e-4, 1000)
    return even, arrival


def test_samples_that_arrive_in_packets_are_put_apart():
    even, stamped = bursts()
    found = evened(stamped, position(even))
    assert found is not None
    assert np.ptp(found - even) < 1e-4
    lost = np.delete(np.arange(len(even)), np.arange(1500, 1510))
    assert evened(stamped[lost], position(even)[lost]) is None, "nobody knows where"


def test_a_joint_that_is_read_in_bursts_keeps_its_stamps():
    _, stamped = bursts()
    assert evened(stamped, position(stamped)) is None
