"""Data sets of another simulator with known answers."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from pyarrow import csv

from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import robot_from_urdf
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording

KINDS = ("train_a", "train_b", "valid_a", "valid_b")


@pytest.fixture
def samples(shared_data: Path) -> Path:
    folder = shared_data / "samples"
    if not folder.is_dir():
        pytest.skip("no sample data sets beside the project")
    return folder


def recording(file: Path) -> Recording:
    table = csv.read_csv(file).to_pydict()

    def columns(kind: str) -> np.ndarray:
        return np.column_stack([table[f"{kind}{j}"] for j in range(1, 8)])

    t = np.array(table["time"])
    return Recording(file.name.split(".")[0], t, columns("q"), columns("tau"))


@cache
def answer(folder: Path, name: str, before: tuple[str, str] = ("train_a", "train_b")):
    """Diagnose one set; frozen where the model comes from other runs than the fitted ones."""
    robot = robot_from_urdf((folder / "robot.urdf").read_text())
    runs = {k: recording(folder / name / f"{k}.csv.gz") for k in {*KINDS, *before}}
    model = identify([runs[k] for k in before], robot, name="m0")
    return diagnose(
        model,
        [runs["train_a"], runs["train_b"]],
        [runs["valid_a"], runs["valid_b"]],
        frozen=before[0] not in KINDS,
    )


def places(found):
    return [(f.term.effect_id, tuple(j + 1 for j in f.term.joints)) for f in found.findings]


@pytest.mark.long
def test_nothing_is_found_where_nothing_is_hidden(samples):
    found = answer(samples, "s01")
    assert found.verdict == "none"
    assert (found.findings, found.unexplained) == ((), ())


@pytest.mark.long
def test_friction_that_grows_with_the_load(samples):
    found = answer(samples, "s02")
    assert places(found) == [("load_friction", (3,))]
    assert found.unexplained == ()
    _falls_to_the_floor(found, 3)


@pytest.mark.long
def test_ripple_of_fifty_cycles(samples):
    found = answer(samples, "s03")
    assert places(found) == [("torque_ripple", (2,))]
    assert found.unexplained == ()
    _within(found, {"N": 50.0})
    _falls_to_the_floor(found, 2)


@pytest.mark.long
def test_a_payload_that_was_not_there_before(samples):
    found = answer(samples, "s04", ("ref_a", "ref_b"))
    assert places(found) == [("payload", ())]
    assert found.unexplained == ()
    _within(found, {"mass": 2.0, "cx": 0.0, "cy": 0.02, "cz": 0.1})
    for joint in range(1, 8):
        _falls_to_the_floor(found, joint)


def _within(found, truth: dict[str, float]) -> None:
    """Within three of the standard errors that come with the values."""
    reported = found.findings[0].parameters
    for name, value in truth.items():
        away = abs(reported[name].value - value) / reported[name].std_error
        assert away < 3.0, f"{name}: {reported[name].value:.4g}, {away:.1f} standard errors off"


def _falls_to_the_floor(found, joint: int) -> None:
    last = found.findings[-1]
    assert last.rms_after[joint - 1] < 1.2 * found.noise_floor[joint - 1]
    assert np.all(last.rms_after < 1.02 * last.rms_before)
