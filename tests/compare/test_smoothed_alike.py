"""Channels of one robot that are smoothed alike tell together what each is too short to tell."""

import compare_arm as arm
import numpy as np
import pytest
from test_smoothed_floor import SIGMA, low_pass, mean, rms_in_band

from pa10d.compare import noise_floor, run_residual
from pa10d.measurement.recording import Recording

SECONDS = 14.0


def floor_of(channels, seed=3):
    """Of a short recording, each joint behind a channel of its own."""
    silent = arm.recording(seed, SECONDS, noise=0.0)
    noise = SIGMA * np.random.default_rng(seed + 70).standard_normal(silent.tau.shape)
    tau = silent.tau + np.column_stack(
        [channel(x[:, None])[:, 0] for channel, x in zip(channels, noise.T, strict=True)]
    )
    return noise_floor([run_residual(arm.model(), Recording("short", silent.t, silent.q, tau))])


@pytest.mark.parametrize("channel", [mean(2), low_pass(60.0)], ids=["mean of 2", "low-pass"])
def test_what_all_share_is_told_of_all(channel):
    """A mean of two samples rolls off as a low-pass does; one short spectrum tells neither."""
    truth = rms_in_band(channel)
    for seed in (4, 6, 8):
        floor = floor_of([channel] * 3, seed)
        assert np.all(np.abs(floor.values - truth) < 3.0 * floor.errors)
        assert np.all(floor.errors < 0.25 * floor.values)


def test_nobody_lends_a_joint_a_channel_that_is_not_its_own():
    """One joint behind a low-pass near the band; the two others are told without it."""
    truth = rms_in_band(mean(2))
    for seed in (4, 5, 8):
        floor = floor_of([low_pass(20.0), mean(2), mean(2)], seed)
        assert np.isnan(floor.values[0])
        assert np.all(np.abs(floor.values[1:] - truth) < 3.0 * floor.errors[1:])
