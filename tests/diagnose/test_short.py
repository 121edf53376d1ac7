"""Seconds of data are answered: bands and cuts follow the motion, not the other way round."""

from __future__ import annotations

import numpy as np
import pytest
from six_fast import LIMITS, NOISE, Extra, recording, robot, two_runs
from small_machines import machine, servo

from pa10d.common.errors import UserError
from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import robot_from_urdf
from pa10d.identify import identify
from pa10d.judgement.band import HIGHEST_HZ, SHORT_MOTION, band
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass

WRIST, ELBOW = np.eye(6)[4], np.eye(6)[3]


def spring(q, dq, ddq, rigid):
    return 1.5 * (q - 0.2) * WRIST


def bump(q, dq, ddq, rigid):
    return 1.2 * np.exp(-((np.abs(dq) / 0.4) ** 2)) * np.tanh(dq / 0.005) * ELBOW


def noise_in_band(run: Recording, cutoff: float) -> np.ndarray:
    """(6,) N·m RMS behind the low-pass of the noise that was put into the torque."""
    white = np.random.default_rng(5).standard_normal((100_000, 1))
    return NOISE * LIMITS * np.std(Lowpass(len(white), run.rate, cutoff)(white))


@pytest.mark.parametrize(
    ("extra", "named"),
    [
        pytest.param(None, [], marks=pytest.mark.long),
        pytest.param(spring, [("spring", (4,))], marks=pytest.mark.long),
        pytest.param(bump, [("stribeck", (3,))], marks=pytest.mark.long),
    ],
    ids=["nothing", "spring", "stribeck"],
)
def test_six_seconds_and_three_are_answered(extra: Extra | None, named):
    fit, judge = two_runs(1, extra)
    found = diagnose(identify([fit], robot(), name="m0"), [fit], [judge])
    assert [(f.term.effect_id, f.term.joints) for f in found.findings] == named
    assert not found.unexplained
    after = found.findings[-1].rms_after if named else found.rms
    torque_noise = noise_in_band(judge, found.cutoff)
    assert np.all(after < 2.0 * torque_noise), "angles, twice differentiated, add as much"
    assert not np.any(after > 1.5 * found.noise_floor), "where these three seconds tell it"
    if extra is spring:
        k = found.findings[0].parameters["k"]
        assert abs(k.value - 1.5) < 3.0 * k.std_error
        assert k.std_error < 0.15


@pytest.mark.long
def test_joints_that_turn_round_often_ask_for_a_wider_band():
    fit, _ = two_runs(1)
    model = identify([fit], robot(), name="m0")
    assert model.notes.cutoff.chosen_by == SHORT_MOTION
    assert HIGHEST_HZ < band(model) == model.cutoff <= 25.0
    slow = recording("slow", 1, 24.0, pace=0.2)
    assert identify([slow], robot(), name="m0").cutoff == HIGHEST_HZ


def test_what_is_too_short_is_said_with_how_much_is_missing():
    fit, judge = two_runs(1)
    model = identify([fit], robot(), name="m0")
    with pytest.raises(UserError, match=r"for the 52 unknowns of m0; expected"):
        diagnose(model, [fit.part(0, 400, "fit")], [judge])
    with pytest.raises(UserError, match=r"independent samples of joint . in motion in the data to"):
        diagnose(model, [fit], [judge.part(0, 300, "judge")])


@pytest.mark.long
def test_a_servo_that_mostly_stands_keeps_half_of_its_motion():
    """Runs of six seconds of one joint that moves for 0.4 s at a time."""
    robot, runs = servo("sin_sin")
    judged = servo("sin_time_square")[1]
    model = identify(runs, robot, name="m0")
    assert model.notes.cutoff.chosen_by == SHORT_MOTION
    found = diagnose(model, runs, judged)
    assert found.findings[0].term.effect_id == "load_friction"
    assert found.left.rms < 0.4 * found.rms


@pytest.mark.long
@pytest.mark.parametrize("name", ["on.csv", "off.csv"])
def test_a_motor_that_turns_on_and_on_is_diagnosed(name):
    robot, runs = machine("laas_motor", [name])
    model = identify(runs, robot, name="m0")
    assert diagnose(model, runs).verdict in ("missing", "unknown", "none")


def test_half_of_a_second_is_refused_in_one_line():
    urdf = (
        '<robot name="one"><link name="a"/><link name="b"/><joint name="j" type="revolute">'
        '<parent link="a"/><child link="b"/><axis xyz="0 1 0"/>'
        '<limit lower="-3" upper="3" effort="9" velocity="9"/></joint></robot>'
    )
    t = np.arange(60) / 100.0
    q = np.sin(9.0 * t)[:, None]
    with pytest.raises(UserError, match=r"too short|too few"):
        identify([Recording("blink", t, q, q)], robot_from_urdf(urdf), name="m0")
