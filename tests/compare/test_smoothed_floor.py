"""The noise floor of torque channels that something smoothed, against the noise that is in them."""

from collections.abc import Callable

import compare_arm as arm
import numpy as np
import pytest
import scipy.signal

from pa10d.compare import noise_floor, run_residual
from pa10d.judgement.noise import ABOVE
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass

SIGMA = 0.3
SECONDS = 40.0
Channel = Callable[[np.ndarray], np.ndarray]


def mean(n: int) -> Channel:
    return lambda x: scipy.signal.lfilter(np.ones(n) / n, [1.0], x, axis=0)


def low_pass(corner: float, order: int = 1) -> Channel:
    b, a = scipy.signal.butter(order, corner, fs=arm.RATE)
    return lambda x: scipy.signal.lfilter(b, a, x, axis=0)


def polynomial(width: int, order: int) -> Channel:
    return lambda x: scipy.signal.savgol_filter(x, width, order, axis=0)


def held(k: int) -> Channel:
    return lambda x: np.repeat(x[::k], k, axis=0)[: len(x)]


def rounded(step: float, before: Channel = lambda x: x) -> Channel:
    return lambda x: np.round(before(x) / step) * step


def rms_in_band(channel: Channel) -> float:
    """RMS behind the low-pass of the noise that a channel passes on, of much of it."""
    noise = SIGMA * np.random.default_rng(99).standard_normal((int(1600 * arm.RATE), 1))
    through = channel(noise)
    return float(np.std(Lowpass(len(noise), arm.RATE, arm.CUTOFF)(through)[500:-500]))


def seen_through(channel: Channel, seed: int = 3):
    silent = arm.recording(seed, SECONDS, noise=0.0)
    noise = SIGMA * np.random.default_rng(seed + 70).standard_normal(silent.tau.shape)
    record = Recording(f"run{seed}", silent.t, silent.q, channel(silent.tau + noise))
    return run_residual(arm.model(), record)


def floor_of(channel: Channel, seed: int = 3):
    return noise_floor([seen_through(channel, seed)])


TOLD = {
    "none": lambda x: x,
    **{f"mean of {n}": mean(n) for n in (2, 3, 5, 8, 13, 20)},
    "mean of means": lambda x: mean(4)(mean(5)(x)),
    "polynomial of 5": polynomial(5, 2),
    "polynomial of 21": polynomial(21, 3),
    "rounded": rounded(0.1),
    "each value three times": held(3),
    "each value four times": held(4),
}


@pytest.mark.parametrize("name", TOLD)
def test_noise_behind_smoothing_is_found_as_strong_as_it_is(name):
    floor, truth = floor_of(TOLD[name]), rms_in_band(TOLD[name])
    assert floor.methods == (ABOVE,) * 3
    assert floor.values == pytest.approx(np.full(3, truth), rel=0.15)
    assert np.all(np.abs(floor.values - truth) < 3.0 * floor.errors)
    assert np.all(floor.errors < 0.25 * floor.values)


UNTOLD = {
    **{f"low-pass at {corner} Hz": low_pass(corner) for corner in (1.0, 5.0, 10.0)},
    "steep low-pass": low_pass(15.0, 4),
    "notches too dense": mean(100),
    "steps of many times the noise": rounded(3.0),
}


@pytest.mark.parametrize("name", UNTOLD)
def test_noise_that_rolls_off_where_nobody_can_see_it_is_not_known(name):
    floor = floor_of(UNTOLD[name])
    assert floor.methods == (None,) * 3
    assert np.all(np.isnan(floor.values))
    assert np.all(np.isnan(floor.errors))


@pytest.mark.parametrize(("others", "known"), [(1, [1, 2]), (2, [])])
def test_one_electronics_smooths_most_joints_or_none(others, known):
    def some(x):
        return np.hstack([low_pass(1.0)(x[:, :others]), x[:, others:]])

    assert np.flatnonzero(np.isfinite(floor_of(some).values)).tolist() == known


@pytest.mark.parametrize("corner", [20.0, 30.0, 50.0, 80.0])
def test_behind_a_low_pass_it_is_found_or_not_known(corner):
    floor, truth = floor_of(low_pass(corner)), rms_in_band(low_pass(corner))
    known = np.isfinite(floor.values)
    assert np.all(np.abs(floor.values - truth)[known] < 3.0 * floor.errors[known])
    assert floor.values[known] == pytest.approx(np.full(known.sum(), truth), rel=0.35)


@pytest.mark.parametrize(("rolled", "known"), [(1, True), (2, False)])
def test_one_run_in_which_it_rolls_off_does_not_hide_what_another_shows(rolled, known):
    """A servo's duty is full of its own motion in one run and shows its steps in the next."""
    runs = [seen_through(low_pass(1.0), 3 + k) for k in range(rolled)]
    alone = seen_through(lambda x: x, 9)
    floor = noise_floor([*runs, alone])
    assert np.isfinite(floor.values).tolist() == [known] * 3
    if known:
        assert floor.values == pytest.approx(noise_floor([alone]).values, rel=0.1)
