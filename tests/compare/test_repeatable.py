"""An error that comes again with the motion is no noise; noise does not, whatever its colour."""

import compare_arm as arm
import numpy as np
import pytest
import scipy.signal

from pa10d.judgement import noise_floor, repeatable, run_residual


def slope(t, q, dq):
    return arm.on_joint(1, 0.4 * q[:, 0] * q[:, 1] * np.tanh(dq[:, 1]))


def seen(*recordings):
    return [run_residual(arm.model(), recording) for recording in recordings]


@pytest.mark.long
@pytest.mark.by_default("0.95")
@pytest.mark.parametrize("coloured", [0.0, 0.95, 0.999])
def test_noise_does_not_come_again(coloured):
    alarms = 0
    for seed in range(12):
        runs = seen(arm.recording(seed, 40.0, coloured=coloured, period=8.0))
        alarms += sum(one.p_value < 0.01 for one in repeatable(runs))
    assert alarms <= 3, "36 joints at 1 %"


def test_an_error_of_three_quantities_comes_again_in_the_next_period():
    found = repeatable(seen(arm.recording(3, 40.0, extra=slope, period=8.0)))
    assert found[1].p_value < 1e-6
    assert found[1].share > 0.5
    assert min(found[0].p_value, found[2].p_value) > 1e-3


def test_a_slow_error_comes_again_in_another_run():
    def lasting(t, q, dq):
        return arm.on_joint(2, 0.5 * np.sin(0.9 * q[:, 0]))

    runs = seen(
        arm.recording(1, 40.0, extra=lasting, noise_seed=5, name="a", coloured=0.9),
        arm.recording(1, 40.0, extra=lasting, noise_seed=6, name="b", coloured=0.9, later=0.2),
    )
    assert repeatable(runs)[2].p_value < 1e-3
    assert repeatable(runs[:1]) == [None] * 3


@pytest.mark.parametrize("every", [1, 2])
def test_a_smoothed_channel_shows_no_noise(every):
    """Behind a smoothing filter nothing is left above the cut-off: that is no floor. Also where the
    recording has so few samples a second that nothing lies beyond what is looked at."""
    raw = arm.recording(1, 40.0, noise=0.3, extra=slope)
    sos = scipy.signal.butter(4, 14.0, fs=arm.RATE, output="sos")
    smoothed = scipy.signal.sosfiltfilt(sos, raw.tau, axis=0)

    def thinned(name, tau):
        return type(raw)(name, raw.t[::every], raw.q[::every], tau[::every])

    floor = noise_floor(seen(thinned("smooth", smoothed)))
    assert floor.methods == (None,) * 3
    assert np.all(np.isnan(floor.values))
    assert noise_floor(seen(thinned("raw", raw.tau))).methods[1] is not None


def test_rounding_is_not_the_noise():
    raw = arm.recording(1, 40.0, noise=0.0, extra=slope)
    coarse = type(raw)("coarse", raw.t, raw.q, np.round(raw.tau / 0.5) * 0.5)
    assert noise_floor(seen(coarse)).methods == (None,) * 3


def test_a_floor_comes_with_its_own_error():
    """The scatter of floors from as much data is what they say of themselves."""
    floors = [
        noise_floor(seen(arm.recording(seed, 24.0, 0.3, period=8.0, coloured=0.9)))
        for seed in range(12)
    ]
    scatter = np.std([floor.values for floor in floors], axis=0)
    said = np.mean([floor.errors for floor in floors], axis=0)
    assert np.all((scatter / said > 0.4) & (scatter / said < 2.5))
