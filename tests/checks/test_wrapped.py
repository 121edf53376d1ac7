"""Angles and counters that begin anew: told by their jumps, mended by one word of a mapping."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.checks import check_recording
from pa10d.measurement.counters import running_over, unwrapped, wrap_of
from pa10d.measurement.recording import Recording
from pa10d.readers import read_recording
from pa10d.services.import_preview import preview_recording
from pa10d.services.robots import load_robot
from pa10d.store.column_mapping import read_unit

T = np.arange(4000) / 200.0
TURNING = 5.0 + 9.0 * np.sin(0.7 * T) + 0.5 * np.sin(3 * T)  # rad, over three turns
NOISE = np.random.default_rng(3).normal(0, 1e-4, len(T))
URDF = """<robot name="one"><link name="base"/><joint name="a" type="continuous">
<parent link="base"/><child link="l"/><axis xyz="0 1 0"/><limit effort="50" velocity="20"/></joint>
<link name="l"><inertial><mass value="3"/><origin xyz="0.2 0 0"/><inertia ixx="0.1" iyy="0.1"
izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""

WRAPPED = {
    "0 … 2π": (np.mod(TURNING + NOISE, 2 * np.pi), "wrap2pi*rad"),
    "±π": (np.mod(TURNING + NOISE + np.pi, 2 * np.pi) - np.pi, "wrap2pi*rad"),
    "0 … 360": (np.mod(np.degrees(TURNING + NOISE), 360), "wrap360*deg"),
    "±180, one decimal": (np.round(np.mod(np.degrees(TURNING) + 180, 360) - 180, 1), "wrap360*deg"),
    "turns": (np.mod((TURNING + NOISE) / (2 * np.pi), 1), "wrap1*rev"),
    "16 bits": (np.mod(np.round(4e4 + TURNING * 4096), 65536), "wrap65536"),
    "12 bits": (np.mod(np.round(TURNING * 4096 / (2 * np.pi)), 4096), "wrap4096"),
    "16 bits with a sign": (
        np.mod(np.round(TURNING * 9000) + 32768, 65536) - 32768, "wrap65536",
    ),
    "hundredths of degrees": (
        np.mod(np.round(100 * np.degrees(TURNING)), 36000), "wrap36000*deg/100",
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", WRAPPED)
def test_the_period_is_told_and_runs_on(kind):
    values, written = WRAPPED[kind]
    found = wrap_of(values)
    assert found is not None
    assert found.written == written
    smooth = unwrapped(values, found.period)
    assert np.abs(np.diff(smooth)).max() < 0.1 * found.period
    again = read_unit(written)(values)
    factor = read_unit(written.partition("*")[2] or "1").factor
    rounds = (smooth * factor - again) / (found.period * abs(factor))
    np.testing.assert_allclose(rounds, np.rint(rounds[0]), atol=1e-9)
    middle = 0.5 * (again.min() + again.max())
    assert abs(middle) <= 0.5 * found.period * abs(factor), "the round nearest to zero"


def test_an_unusual_counter_is_named_without_a_guess():
    values = np.mod(np.round(TURNING * 10_000 / (2 * np.pi)), 10_000)
    found = running_over(values)
    assert found is not None
    assert not found.told
    assert found.period == pytest.approx(10_000, rel=0.01)
    (said,) = check_recording(_recording(values), None, None, delay=False)[:1]
    assert said.code == "wrapped"
    assert "begins anew after about 1000" in said.sentence
    assert "q1[wrapCOUNTS]=q1" in said.advice
    assert not said.mends[0].complete


def test_one_turn_is_enough():
    values = np.mod(3.0 + 0.5 * T, 2 * np.pi)[:2000]
    assert (np.abs(np.diff(values)) > 1).sum() == 1
    found = running_over(values)
    assert found is not None
    assert found.written == "wrap2pi*rad"


def test_resting_where_it_begins_anew():
    still = np.where(T > 10, 0.0, 3 * np.sin(np.pi * T / 10)) + 3e-4 * np.sin(900 * T)
    found = running_over(np.mod(still, 2 * np.pi))
    assert found is not None
    assert found.written == "wrap2pi*rad"


GONE = np.arange(len(T)) % 700 == 5
SOUND = {
    "a motion": TURNING,
    "a slow square": np.sign(np.sin(T)) * (1 + 0.01 * np.sin(20 * T)),
    "two recordings in one": np.concatenate([TURNING[:2000] * 0.1, 5.1 + TURNING[2000:] * 0.1]),
    "a reading of nothing now and then": np.where(GONE, 0.0, 4 + TURNING / 9),
    "at rest": np.full(len(T), 1.0),
    "coarse": np.round(TURNING, 1),
    "a sensor between two levels": 3.8e-4 * (np.random.default_rng(2).uniform(size=len(T)) > 0.9),
    "a sensor between three": 3.8e-4 * np.random.default_rng(2).integers(0, 3, len(T)),
    "noise": np.random.default_rng(2).normal(0, 1, len(T)),
}  # fmt: skip


@pytest.mark.parametrize("kind", SOUND)
def test_what_never_begins_anew_is_left_alone(kind):
    assert wrap_of(SOUND[kind]) is None


def _recording(q, tau=None):
    tau = np.cos(3 * T) + NOISE if tau is None else tau
    return Recording("r", T[: len(q)], q[:, None], tau[: len(q), None])


@pytest.mark.by_default("0.0-360")
@pytest.mark.parametrize(("period", "unit"), [("360", "deg"), ("2pi", "rad")])
@pytest.mark.parametrize("late", [0.0, 1e-3])
def test_a_file_is_mended_by_what_is_advised(tmp_path, period, unit, late):
    """Also where the stamps are irregular: the jump is found before steps become equal."""
    (tmp_path / "one.urdf").write_text(URDF)
    stamps = T + late * np.random.default_rng(1).uniform(0, 1, len(T))
    once = 360.0 if period == "360" else 2 * np.pi
    turning = 5.0 + 9.0 * np.sin(0.7 * stamps) + 0.5 * np.sin(3 * stamps)
    q = np.mod(turning / read_unit(unit).factor, once)
    rows = (f"{t!r},{a!r},{b!r}\n" for t, a, b in zip(
        stamps.tolist(), q.tolist(), np.cos(3 * stamps).tolist(), strict=True))  # fmt: skip
    path = tmp_path / "log.csv"
    path.write_text("time,q1,tau1\n" + "".join(rows))
    arm = load_robot(tmp_path / "one.urdf")
    found = preview_recording(path, *arm)
    assert found.problem == ""
    assert [c.unit for c in found.columns if c.field == "q1"] == [f"wrap{period}*{unit}"]
    assert {f.finding.code for f in found.findings} & {
        "wrapped",
        "jump",
        "degrees",
        "angle_unit",
    } == set()
    run = read_recording(path, *arm, found.rules)
    grid = run.timing.grid
    expected = 5.0 + 9.0 * np.sin(0.7 * grid) + 0.5 * np.sin(3 * grid)
    turns = (run.samples.q[:, 0] - expected) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns[0]), atol=1e-4)


def test_lost_sign_and_running_over_in_one_column():
    counts = np.round(TURNING * 9000)
    values = read_unit("i16*wrap65536*deg")(np.mod(counts, 65536))
    away = (values / np.radians(1) - counts) / 65536
    np.testing.assert_allclose(away, np.rint(away[0]), atol=1e-9)


@pytest.mark.parametrize("text", ["wrap", "wrap0", "wrapper", "deg/wrap360", "wrap360*wrap360"])
def test_words_that_are_none(text):
    with pytest.raises((ValueError, ZeroDivisionError)):
        read_unit(text)
