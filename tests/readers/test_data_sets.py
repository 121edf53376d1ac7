"""LeRobot data sets: which of many episodes, spread over files, with stamps of 32 bits."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from test_formats import JOINTS

import pa10d
from pa10d.cli import main
from pa10d.common.errors import UserError
from pa10d.readers import Part, episodes_of, read_recording, read_table
from pa10d.store import RunStore

FPS = 50
LENGTHS = {0: 150, 1: 400, 2: 90, 7: 250}
FILES = {"chunk-000/file-000": (0, 1), "chunk-000/file-001": (2,), "chunk-001/file-000": (7, 2)}
MAP = [
    *(f"observation.state.{joint}.pos=q{j}" for j, joint in enumerate(JOINTS, 1)),
    *(f"observation.effort.{joint}.eff=tau{j}" for j, joint in enumerate(JOINTS, 1)),
]


def course(episode, frames):
    t = np.asarray(frames) / FPS
    return np.stack([np.sin((1 + episode) * t), 0.3 * np.cos(2 * t) + 0.01 * episode], axis=1)


def table(episode, frames):
    q = course(episode, frames)
    return {
        "observation.state": q.astype(np.float32).tolist(),
        "observation.effort": (10 * q).astype(np.float32).tolist(),
        "action": (q + 5).tolist(),
        "timestamp": (np.asarray(frames) / FPS).astype(np.float32),
        "frame_index": np.asarray(frames),
        "episode_index": np.full(len(frames), episode),
    }


def joined(tables):
    columns = {name: [v for one in tables for v in one[name]] for name in tables[0]}
    return pa.table({name: pa.array(values) for name, values in columns.items()})


def data_set(folder, fps=FPS, total=4, change=lambda made: made):
    """Version 3: episodes 0 and 1 in one file, the frames of episode 2 in two, later ones first."""
    path = folder / "set"
    (path / "meta").mkdir(parents=True)
    named = {
        f"observation.{kind}": {"names": {"motors": [f"{joint}.{end}" for joint in JOINTS]}}
        for kind, end in (("state", "pos"), ("effort", "eff"))
    }
    info = {"codebase_version": "v3.0", "fps": fps, "total_episodes": total, "features": named}
    (path / "meta" / "info.json").write_text(json.dumps(info))
    for place, episodes in FILES.items():
        parts = []
        for episode in episodes:
            frames = np.arange(LENGTHS[episode])
            if episode == 2:
                frames = frames[50:] if "chunk-000" in place else frames[:50]
            parts.append(change(table(episode, frames)))
        out = path / "data" / f"{place}.parquet"
        out.parent.mkdir(parents=True, exist_ok=True)
        parquet.write_table(joined(parts), out)
    return path


def test_the_longest_episode_is_taken_and_said(tmp_path, robot):
    found = read_recording(data_set(tmp_path), *robot, MAP)
    np.testing.assert_allclose(found.samples.q, course(1, np.arange(400)), atol=1e-6)
    np.testing.assert_allclose(found.samples.tau, 10 * course(1, np.arange(400)), atol=1e-5)
    (said,) = [line for line in found.header_warnings if "LeRobot" in line]
    assert "episode 1, the longest of 4" in said
    assert found.another.startswith("--episode N takes another")


@pytest.mark.parametrize("episode", [0, 7])
def test_any_episode_can_be_asked_for(tmp_path, robot, episode):
    found = read_recording(data_set(tmp_path), *robot, MAP, part=Part(episode=episode))
    expected = course(episode, np.arange(LENGTHS[episode]))
    np.testing.assert_allclose(found.samples.q, expected, atol=1e-6)
    assert not any("longest" in line for line in found.header_warnings)


def test_an_episode_over_two_files_is_one_in_the_order_of_its_frames(tmp_path, robot):
    found = read_table(data_set(tmp_path), *robot, part=Part(episode=2)).columns
    np.testing.assert_array_equal(found["frame_index"], np.arange(90))
    expected = course(2, np.arange(90))[:, 0]
    np.testing.assert_allclose(found["observation.state.shoulder.pos"], expected, atol=1e-6)


def test_stamps_of_32_bits_are_the_frames(tmp_path, robot):
    found = read_table(data_set(tmp_path), *robot).columns
    np.testing.assert_array_equal(found["time"], np.arange(400) / FPS)


def test_stamps_that_are_not_the_frames_are_believed(tmp_path, robot):
    found = read_table(data_set(tmp_path, fps=30), *robot)
    np.testing.assert_allclose(np.diff(found.columns["time"]), 1 / FPS, atol=1e-6)
    assert any("30 frames a second of meta/info.json" in line for line in found.remarks)


def test_without_stamps_the_rate_is_the_data_set_s(tmp_path, robot):
    def bare(made):
        return {name: values for name, values in made.items() if name != "timestamp"}

    found = read_table(data_set(tmp_path, change=bare), *robot)
    np.testing.assert_array_equal(found.columns["time"], np.arange(400) / FPS)


def test_one_file_of_a_data_set_is_its_longest_episode(tmp_path, robot):
    path = data_set(tmp_path) / "data" / "chunk-001" / "file-000.parquet"
    found = read_recording(path, *robot, MAP)
    assert len(found.samples) == LENGTHS[7]
    assert "episode 7, the longest of 2" in " ".join(found.header_warnings)


def test_what_is_not_here_is_said(tmp_path, robot):
    found = read_table(data_set(tmp_path, total=99), *robot)
    assert any("99 episodes by meta/info.json, 4 of them are here" in r for r in found.remarks)
    with pytest.raises(UserError, match=r"no episode 5 in the 4 that are here, expected 0 … 7"):
        read_table(tmp_path / "set", *robot, part=Part(episode=5))


def test_shares_of_a_range_are_not_taken_for_degrees_without_a_word(tmp_path, robot):
    def shares(made):
        return {**made, "observation.state": np.clip(99 * np.array(made["action"]), -100, 100)}

    def as_lists(made):
        return {**shares(made), "observation.state": shares(made)["observation.state"].tolist()}

    found = read_table(data_set(tmp_path, change=as_lists), *robot)
    assert any("−100 … 100 of each joint's range" in line for line in found.remarks)


def test_others_have_no_episodes(tmp_path, robot):
    path = tmp_path / "run.csv"
    path.write_text("time,q1,q2,tau1,tau2\n" + "1,2,3,4,5\n" * 150)
    with pytest.raises(UserError, match=r"no episodes; --episode 3 expects a LeRobot data set"):
        read_recording(path, *robot, part=Part(episode=3))
    with pytest.raises(UserError, match=r"no topics; --topic /a expects a bag, or a CAN log"):
        read_recording(path, *robot, part=Part(topic="/a"))
    with pytest.raises(UserError, match=r"--episode all expects a LeRobot data set"):
        episodes_of(path)


def test_a_packed_data_set_gives_any_episode_and_not_all_at_once(tmp_path, robot):
    path = data_set(tmp_path)
    packed = Path(shutil.make_archive(str(tmp_path / "packed"), "gztar", tmp_path, "set"))
    found = read_recording(packed, *robot, MAP, part=Part(episode=0))
    np.testing.assert_allclose(found.samples.q, course(0, np.arange(150)), atol=1e-6)
    with pytest.raises(UserError, match=r"packed; --episode all expects the data set's folder"):
        episodes_of(packed)
    assert episodes_of(path) == LENGTHS


def test_each_episode_as_a_run(tmp_path, robot, capsys):
    path, data = data_set(tmp_path), ["--data", str(tmp_path / "data")]
    line = [*data, "run", "import", str(path), "--profile", str(tmp_path / "robot.urdf")]
    assert main([*line, "--name", "all", "--episode", "all", "--map", *MAP]) == 1
    said = capsys.readouterr()
    assert "episode 2: " in said.err
    assert "found 90 samples, expected at least 100" in said.err
    assert "3 episodes stored, 1 refused" in said.err
    runs = RunStore(tmp_path / "data").all()
    assert {run.name: run.samples for run in runs} == {"all-0": 150, "all-1": 400, "all-7": 250}
    assert main([*line, "--episode", "7", "--map", *MAP]) == 0
    assert RunStore(tmp_path / "data").find("set-7").samples == 250
    with pytest.raises(SystemExit):
        main([*line, "--episode", "most"])
    assert "found 'most', expected a number from 0 or 'all'" in capsys.readouterr().err


def test_the_same_in_python(tmp_path, robot):
    path = data_set(tmp_path)
    mapping = dict(rule.split("=") for rule in MAP)
    run = pa10d.load_run(
        path, pa10d.load_robot(tmp_path / "robot.urdf"), map=mapping, force=True, episode=0
    )
    assert len(run) == 150
