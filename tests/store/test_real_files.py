"""Every recording of a real robot beside the project loads, whatever is odd about it."""

from __future__ import annotations

import csv
import gzip

import numpy as np
import pytest

from pa10d.profile import load_profile
from pa10d.services.robots import load_robot
from pa10d.services.runs import import_run
from pa10d.store import RunStore

REAL = {
    "kr300": (["train1", "train2", "valid1"], 250.0, ""),
    "kuka_lwr4": (["train1", "valid1", "valid2"], 200.0, "scatter"),
    "panda": (["train1", "valid1"], 1000.0, "irregular"),
    "ur10": (["train1", "valid1"], 125.0, ""),
}
FILES = [(robot, name) for robot, (names, *_) in REAL.items() for name in names]
SAMPLES = [
    (f"s0{k}", f"{kind}_{part}")
    for k in range(1, 5)
    for kind in ("train", "valid")
    for part in "ab"
]


def _imported(store, file, urdf):
    profile, robot = load_robot(urdf)
    return import_run(store, file, profile, robot, replace=True).info, robot


def _column(file, name):
    with gzip.open(file, "rt") if file.suffix == ".gz" else file.open() as text:
        return np.array([float(row[name]) for row in csv.DictReader(text)])


@pytest.mark.by_default("kr300-train1", "kuka_lwr4-valid1", "panda-valid1", "ur10-train1")
@pytest.mark.parametrize(("robot", "name"), FILES, ids=lambda v: v)
def test_a_real_recording_loads(shared_data, tmp_path, robot, name):
    store, folder = RunStore(tmp_path), shared_data / robot
    file = folder / f"{name}.csv"
    info, arm = _imported(store, file, folder / "robot.urdf")
    recording = store.recording(info)
    _, rate, irregular = REAL[robot]
    assert recording.rate == pytest.approx(rate, rel=1e-6)
    assert recording.joints == arm.n
    told = [w for w in ("irregular", "scatter") if any(w in line for line in info.warnings)]
    assert told == ([irregular] if irregular else [])
    steps = np.diff(recording.t)
    np.testing.assert_allclose(steps, steps[0], rtol=1e-6)
    time, q1, tau2 = (_column(file, c) for c in ("time", "q1", "tau2"))
    assert recording.duration == pytest.approx(time[-1] - time[0], abs=1.1 / rate)
    if irregular == "irregular":
        unique = np.concatenate([[True], np.diff(time) > 0])
        expected = np.interp(recording.t, time[unique], q1[unique])
        assert np.abs(recording.q[:, 0] - expected).max() < 2e-3
    else:
        np.testing.assert_array_equal(recording.q[:, 0], q1)
        np.testing.assert_array_equal(recording.tau[:, 1], tau2)


def test_what_is_odd_about_them_is_said_and_kept(shared_data, tmp_path):
    store = RunStore(tmp_path)
    kr300, _ = _imported(store, shared_data / "kr300/train1.csv", shared_data / "kr300/robot.urdf")
    assert any("joint 2 (joint2): q reaches" in w and "beyond" in w for w in kr300.warnings)
    assert {"taumot1", "qse6"} <= set(store.recording(kr300).extra)
    ur10, _ = _imported(store, shared_data / "ur10/train1.csv", shared_data / "ur10/robot.urdf")
    current = store.read(ur10).samples.current
    np.testing.assert_array_equal(current[:, 3], _column(shared_data / "ur10/train1.csv", "i4"))
    assert "i4" in store.recording(ur10).extra


@pytest.mark.by_default("s01-train_a", "s04-valid_b")
@pytest.mark.parametrize(("folder", "name"), SAMPLES, ids=lambda v: v)
def test_a_simulated_sample_loads_to_the_digit(shared_data, tmp_path, folder, name):
    file = shared_data / "samples" / folder / f"{name}.csv.gz"
    store = RunStore(tmp_path)
    info, _ = _imported(store, file, shared_data / "samples/robot.urdf")
    recording = store.recording(info)
    assert info.warnings == ()
    assert recording.rate == pytest.approx(500.0, rel=1e-12)
    np.testing.assert_array_equal(recording.tau[:, 6], _column(file, "tau7"))


def test_currents_alone_do_with_torque_constants(shared_data, tmp_path):
    """The UR10's effort column is current times these gains: dropping it must give it back."""
    folder = shared_data / "ur10"
    gains = [13.5841, 14.2959, 11.3716, 11.2408, 11.7681, 11.7682]
    profile = tmp_path / "ur10.yaml"
    profile.write_text(f"urdf: {folder / 'robot.urdf'}\ntorque_constants: {gains}\n")
    with (folder / "train1.csv").open() as source, (tmp_path / "i.csv").open("w") as target:
        rows = csv.DictReader(source)
        kept = [name for name in rows.fieldnames if not name.startswith("tau")]
        writer = csv.DictWriter(target, kept, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    store = RunStore(tmp_path)
    assert load_profile(profile).torque_constants == gains
    info, _ = _imported(store, tmp_path / "i.csv", profile)
    expected = _column(folder / "train1.csv", "tau3")
    np.testing.assert_allclose(store.recording(info).tau[:, 2], expected, rtol=1e-5, atol=1e-4)
