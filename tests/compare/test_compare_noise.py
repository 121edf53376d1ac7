"""The noise floor against the noise that was put in."""

from dataclasses import replace

import compare_arm as arm
import numpy as np
import pytest
import scipy.signal

from pa10d.compare import noise_floor, run_residual
from pa10d.judgement.noise import ABOVE, REPEATS, STANDSTILL, _Seen, _slow
from pa10d.judgement.repeats import overlap, period, same_motion

SIGMA = 0.3


def truth(coloured=0.0):
    """RMS of the noise behind the low-pass, by filtering much of it forward and backward."""
    noise = np.random.default_rng(99).standard_normal(400_000)
    gain = np.sqrt(1 - coloured**2)
    noise = scipy.signal.lfilter([gain], [1, -coloured], noise)
    sos = scipy.signal.butter(4, arm.CUTOFF, fs=arm.RATE, output="sos")
    return SIGMA * float(np.std(scipy.signal.sosfiltfilt(sos, noise)))


def slope(t, q, dq):
    return arm.on_joint(1, 2.0 * q[:, 1] + np.tanh(dq[:, 1]))


def seen(*recordings):
    return noise_floor([run_residual(arm.model(), recording) for recording in recordings])


@pytest.mark.parametrize("coloured", [0.0, 0.95])
def test_periods_show_the_noise_whatever_its_colour_and_the_models_error(coloured):
    record = arm.recording(1, 60.0, SIGMA, slope, coloured=coloured, period=10.0)
    floor = seen(record)
    assert floor.methods == (REPEATS,) * 3
    assert floor.values == pytest.approx(np.full(3, truth(coloured)), rel=0.12)


def test_a_second_run_of_the_same_motion_shows_the_noise():
    floor = seen(
        arm.recording(1, 40.0, SIGMA, slope, noise_seed=5, name="a"),
        arm.recording(1, 40.0, SIGMA, slope, noise_seed=6, name="b", later=0.812),
    )
    assert floor.methods == (REPEATS,) * 3
    assert floor.values == pytest.approx(np.full(3, truth()), rel=0.12)


def test_without_repetition_the_spectrum_above_the_cutoff_tells():
    floor = seen(arm.recording(1, 60.0, SIGMA, slope))
    assert floor.methods == (ABOVE,) * 3
    assert floor.values == pytest.approx(np.full(3, truth()), rel=0.2)


@pytest.mark.parametrize("sigma", [0.05, SIGMA])
def test_what_a_servo_answers_to_its_encoder_is_no_noise(sigma):
    """It grows with frequency: the floor was 2 and 10 times the noise. Here it is not known."""
    record = arm.recording(1, 60.0, sigma, slope)
    read = record.q + 5e-5 * np.random.default_rng(2).standard_normal(record.q.shape)
    speed = np.diff(read - record.q, axis=0, prepend=0.0) * arm.RATE
    answer = scipy.signal.lfilter([0.3], [1.0, -0.7], speed, axis=0)
    answer *= 5.0 * SIGMA / np.std(answer)
    found = seen(replace(record, q=read, tau=record.tau - answer))
    assert not np.any(found.values > 1.3 * truth() * sigma / SIGMA)


@pytest.mark.parametrize("fall", [0.6, 1.0, 1.7, 2.3])
def test_however_fast_a_spectrum_falls_noise_is_no_slower_than_a_random_walk(fall):
    """An error whose kinks fell off as 1/f³ was no claim at 1800 times its floor: noise that went
    on like that might have been 6800 times as strong within the band."""
    run = run_residual(arm.model(), arm.recording(1, 60.0, SIGMA))
    allowed = _slow([run], _Seen(1.0, 50, 0.1, fall))
    assert allowed == pytest.approx(4.0 * np.sqrt(60.0 * arm.CUTOFF - 1.0), rel=0.02)


def test_noise_that_grows_towards_rest_is_no_stronger_than_it_is_said_it_may_be():
    """Slow noise under white noise of a tenth of it: the floor is thirty times too low."""
    record, told = arm.recording(1, 60.0, 0.0), []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        drive = np.sqrt(1 - 0.999**2) * rng.standard_normal((2 * len(record.t), 3))
        slow = scipy.signal.lfilter([1.0], [1, -0.999], drive, axis=0)[len(record.t) :]
        noise = SIGMA * (slow - slow.mean(axis=0)) + 0.02 * rng.standard_normal(record.tau.shape)
        run = run_residual(arm.model(), replace(record, tau=record.tau + noise))
        inside = np.std(run.equation.lowpass.of_torque(noise), axis=0)
        floor = noise_floor([run])
        grows = np.isfinite(floor.slow) & (floor.slow > 1.0)
        assert np.all(inside[grows] < floor.slow[grows] * floor.values[grows])
        told += list(inside[grows] / floor.values[grows])
    assert max(told) > 20.0


def test_standstill_shows_slow_noise_that_the_spectrum_above_does_not():
    record = arm.recording(1, 60.0, SIGMA, coloured=0.95, extra=slope)
    q, tau = record.q.copy(), record.tau.copy()
    noise = scipy.signal.lfilter(
        [np.sqrt(1 - 0.95**2)], [1, -0.95], np.random.default_rng(3).standard_normal(6000)
    )
    rest = slice(6000, 12000)
    q[rest], tau[rest, 1] = q[6000], 4.0 + SIGMA * noise
    floor = seen(type(record)("rest", record.t, q, tau))
    assert floor.methods[1] == STANDSTILL
    assert floor.values[1] == pytest.approx(truth(0.95), rel=0.25)


def test_a_joint_that_stands_alone_shows_no_noise_but_what_friction_takes_off_it():
    record = arm.recording(1, 60.0, SIGMA, slope)
    q, tau = record.q.copy(), record.tau.copy()
    rest = slice(6000, 12000)
    q[rest, 1] = q[6000, 1]
    tau[rest, 1] = 4.0 + np.sin(2 * np.pi * 3.0 * record.t[rest])
    assert seen(type(record)("alone", record.t, q, tau)).methods[1] != STANDSTILL


def test_period_and_shift_of_a_motion():
    repeated = arm.recording(1, 35.0, period=8.0)
    assert period(repeated.q, arm.RATE) == pytest.approx(8.0 * arm.RATE, abs=1)
    one, other = arm.recording(1, 30.0), arm.recording(1, 30.0, later=0.6)
    assert period(one.q, arm.RATE) is None
    assert same_motion(one.q, other.q, arm.RATE) == -150
    assert same_motion(one.q, arm.recording(2, 30.0).q, arm.RATE) is None


def test_overlap_pairs_the_same_instants():
    a, b = overlap(10, 8, 3)
    assert (a, b) == (slice(0, 5), slice(3, 8))
    a, b = overlap(10, 8, -4)
    assert (a, b) == (slice(4, 10), slice(0, 6))
