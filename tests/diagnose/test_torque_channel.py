"""A low-pass of the torque channel is recognised, and model and measurement pass it alike."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest
import scipy
from two_links import NAMES, recordings, robot

from pa10d.diagnose.procedure import diagnose
from pa10d.identify.advice import _timing
from pa10d.identify.channel import FoundChannel
from pa10d.identify.procedure import identify
from pa10d.identify.timing import Shift
from pa10d.judgement import run_residual
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass, through_channel
from pa10d.measurement.torque_filter import DELAYS, TorqueFilter
from pa10d.store.model_parse import read_model
from pa10d.store.model_text import model_text
from pa10d.store.models import new_info

HERTZ = 4.0
SLOWER = 2.5  # Hz: later by 64 ms than what one joint would be believed
RATE = 500.0


def drive(run: Recording, hertz: float = HERTZ) -> Recording:
    """A first-order low-pass, as firmware steps it."""
    pole = np.exp(-2 * np.pi * hertz / run.rate)
    tau, _ = scipy.signal.lfilter([1 - pole], [1, -pole], run.tau, axis=0, zi=pole * run.tau[:1])
    return Recording(run.name, run.t, run.q, tau)


def weakening(t, q, dq, ddq):
    """(N, 2): joint 1 rubs more while it is slow."""
    extra = np.exp(-((dq[:, 0] / 0.1) ** 2)) * np.tanh(dq[:, 0] / 0.01)
    return np.column_stack([extra, np.zeros(len(t))])


@cache
def smoothed(extra=None):
    """Recordings and what is identified from half of them."""
    made = recordings(3, extra=extra)
    runs = [drive(made[name]) for name in NAMES]
    return runs, identify(runs[:2], robot(), name="m0")


def test_the_low_pass_of_the_channel_is_found():
    _, model = smoothed()
    assert model.channel.kind == "first order"
    assert 0.5 / np.pi / model.channel.seconds == pytest.approx(HERTZ, rel=0.15)
    (line,) = (line for line in model.notes.warnings if "a low-pass of first order" in line)
    told, error = (float(x) for x in re.search(r"at ([\d.]+) ± ([\d.]+) Hz", line).groups())
    assert abs(told - HERTZ) < 3.0 * error < 0.3 * HERTZ


@pytest.mark.parametrize(("times", "said"), [(1.1, False), (1.6, True)])
def test_a_filter_is_later_than_torque_only_beyond_what_its_time_is_unsure_by(times, said):
    """20.7 Hz for 25 was told as "angles are late as well": 20.7 ± 2.5."""
    shift = Shift(0.0064, 0.0064, 0.00005, np.full(2, 0.0064))
    channel = FoundChannel(TorqueFilter("first order", times * shift.seconds), 0.0008)
    assert ("more than torque is" in " ".join(_timing(shift, channel))) == said


@pytest.mark.long
def test_a_low_pass_that_all_joints_agree_on_may_be_late_by_more_than_one_would_be():
    made = recordings(3)
    model = identify([drive(made[name], SLOWER) for name in NAMES[:2]], robot(), name="m0")
    assert 0.5 / np.pi / model.channel.seconds == pytest.approx(SLOWER, rel=0.15)
    assert model.shift == pytest.approx(0.5 / np.pi / SLOWER, rel=0.15)


@pytest.mark.long
def test_a_smeared_step_of_friction_is_nothing_that_the_arm_lacks():
    runs, model = smoothed()
    assert diagnose(model, runs[:2], runs[2:]).verdict == "none"


@pytest.mark.long
def test_friction_that_weakens_is_named_behind_a_low_pass_too():
    runs, model = smoothed(weakening)
    (found,) = diagnose(model, runs[:2], runs[2:]).findings
    assert (found.term.effect_id, found.term.joints) == ("stribeck", (0,))
    speed = found.parameters["vs"]
    assert abs(speed.value - 0.1) < 4 * speed.std_error
    assert speed.std_error < 0.02


def test_a_stored_model_keeps_its_channel(tmp_path):
    _, model = smoothed()
    path = tmp_path / "m0.yaml"
    path.write_text(model_text(model, new_info(model, None)))
    assert read_model(path)[0].channel == model.channel


def test_an_arm_that_is_not_smoothed_has_no_channel():
    made = recordings(3)
    assert identify([made["fit_a"], made["fit_b"]], robot(), name="m0").channel is None


def test_columns_pass_what_torque_has_passed():
    """The raw error, too: of the true model nothing but noise is left."""
    runs, model = smoothed()
    seen = run_residual(model, runs[2])
    inner = seen.raw_judged
    assert seen.raw_error[inner].std() < 2 * np.mean(model.noise)


@pytest.mark.parametrize("kind", list(DELAYS))
def test_a_channel_is_its_filter_without_the_delay(kind):
    seconds = {"first order": 0.02, "second order": 0.02, "mean": 0.051}[kind]
    t = np.arange(4000) / RATE
    x = np.sin(2 * np.pi * 1.3 * t) + np.sign(np.sin(2 * np.pi * 0.31 * t))
    corner = 0.5 / np.pi / seconds
    if kind == "mean":
        n = round(seconds * RATE)
        known, late = scipy.ndimage.uniform_filter1d(x, n), 0.0
    else:
        b, a = scipy.signal.butter(1 if kind == "first order" else 2, corner / (RATE / 2))
        known, late = scipy.signal.lfilter(b, a, x), DELAYS[kind] * seconds
    channel = TorqueFilter(kind, n / RATE if kind == "mean" else seconds)
    found = through_channel(x[:, None], channel, RATE)[:, 0]
    lag = round(late * RATE)
    inner = slice(500, 3500)
    assert channel.delay == pytest.approx(DELAYS[kind] * channel.seconds)
    off = found[inner] - known[500 + lag : 3500 + lag]
    assert np.sqrt(np.mean(off**2)) < 0.03
    low = Lowpass(len(t), RATE, 12.0, channel=channel)
    both = low(x[:, None])[inner] - low.of_torque(found[:, None])[inner]
    assert np.abs(both).max() < 1e-3
