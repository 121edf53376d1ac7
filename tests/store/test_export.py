"""Exports hold what the run holds, and CSV comes back as it went."""

from __future__ import annotations

import numpy as np
import pytest
from pyarrow import parquet
from rosbags.rosbag2 import Reader
from scipy.io import loadmat
from store_data import ALL, channels, motion, plain_table, samples, write_csv

from pa10d.common.errors import UserError
from pa10d.store import Channels, RunStore
from pa10d.store.csv_import import read_csv
from pa10d.store.export import export_run


@pytest.fixture
def store(tmp_path):
    store = RunStore(tmp_path / "data")
    writer = store.start("full", channels(**ALL))
    writer.append(samples(start_ns=12_000_000_007, **ALL))
    writer.close()
    return store


def _export(store, form, out, replace=False):
    info = store.find("full")
    export_run(store, info, form, out, replace)
    return store.read(info).samples


def _again(store, path, n):
    found = read_csv(path, n, "arm")
    extra = tuple(found.samples.extra)
    have = Channels(tuple("abcdefg"[:n]), found.samples.dq is not None,
                    temperature=found.samples.temperature is not None,
                    current=found.samples.current is not None, extra=extra)  # fmt: skip
    with store.building(None, "again", have, time_zero_ns=found.time_zero_ns) as writer:
        writer.append(found.samples)
    return store.read(writer.info)


def test_csv_round_trip_to_the_last_bit(store, tmp_path):
    out = tmp_path / "full.csv"
    written = _export(store, "csv", out)
    read = _again(store, out, 3).samples
    np.testing.assert_array_equal(np.diff(read.stamps), np.diff(written.stamps))
    for name in ("q", "tau", "dq", "temperature", "current"):
        np.testing.assert_array_equal(getattr(read, name), getattr(written, name))
    for name in ALL["extra"]:
        np.testing.assert_array_equal(read.extra[name], written.extra[name])
    np.testing.assert_array_equal(read.extra["tau_cmd2"], written.commands.tau[:, 1])


@pytest.mark.parametrize("start", [0.0, 3.75, -2.5, 1_763_712_345.0])
def test_csv_keeps_the_file_s_own_time(store, tmp_path, start):
    t, q, tau = motion()
    first = write_csv(tmp_path / "in.csv", plain_table(t + start, q, tau))
    run = _again(store, first, 2)
    export_run(store, store.find("again"), "csv", tmp_path / "out.csv", False)
    twice = read_csv(tmp_path / "out.csv", 2, "arm")
    assert twice.time_zero_ns == run.time_zero_ns
    assert np.abs(twice.samples.stamps - run.samples.stamps).max() <= (500 if start > 1e9 else 0)
    np.testing.assert_array_equal(twice.samples.q, run.samples.q)
    with (tmp_path / "out.csv").open() as file:
        next(file)
        assert float(next(file).split(",")[0]) == pytest.approx(start, abs=1e-6)


def test_csv_shows_holes_of_extra_channels_as_it_found_them(store, tmp_path):
    table = plain_table(*motion())
    table["sparse"] = np.where(np.arange(400) % 2, np.nan, 1.5)
    run = _again(store, write_csv(tmp_path / "in.csv", table), 2)
    export_run(store, store.find("again"), "csv", tmp_path / "out.csv", False)
    twice = read_csv(tmp_path / "out.csv", 2, "arm").samples
    np.testing.assert_array_equal(twice.extra["sparse"], run.samples.extra["sparse"])


def test_parquet(store, tmp_path):
    written = _export(store, "parquet", tmp_path / "x.parquet")
    table = parquet.read_table(tmp_path / "x.parquet")
    np.testing.assert_array_equal(table["q3"].to_numpy(), written.q[:, 2])
    np.testing.assert_array_equal(table["q_cmd1"].to_numpy(), written.commands.q[:, 0])
    np.testing.assert_array_equal(table["motor torque [Nm]"], written.extra["motor torque [Nm]"])
    np.testing.assert_allclose(np.diff(table["time"].to_numpy()), 0.002, atol=1e-12)
    assert table.schema.metadata[b"joints"] == b"S1,S2,E1"


def test_mat(store, tmp_path):
    written = _export(store, "mat", tmp_path / "x.mat")
    content = loadmat(tmp_path / "x.mat", simplify_cells=True)
    np.testing.assert_array_equal(content["q"], written.q)
    np.testing.assert_array_equal(content["command"]["tau"], written.commands.tau)
    np.testing.assert_array_equal(content["temperature"], written.temperature)
    assert list(content["joints"]) == ["S1", "S2", "E1"]
    assert content["info"]["name"] == "full"
    extra = content["extra"]
    np.testing.assert_array_equal(extra["motor_torque__Nm_"], written.extra["motor torque [Nm]"])
    np.testing.assert_array_equal(extra["x7"], written.extra["7"])


def test_mcap_alone_is_a_bag(store, tmp_path):
    written = _export(store, "mcap", tmp_path / "x.mcap")
    with Reader(tmp_path / "x.mcap") as reader:
        assert reader.message_count == 8 * len(written)


def test_an_existing_file_is_kept_unless_replaced(store, tmp_path):
    out = tmp_path / "x.csv"
    out.write_text("mine")
    with pytest.raises(UserError, match=r"x\.csv: exists already; expected"):
        _export(store, "csv", out)
    assert out.read_text() == "mine"
    _export(store, "csv", out, replace=True)
    assert out.read_text().startswith("time,q1")
    with pytest.raises(UserError, match="a folder; expected the name of a file"):
        _export(store, "csv", tmp_path)


def test_a_failing_export_leaves_the_old_file(store, tmp_path, monkeypatch):
    out = tmp_path / "x.csv"
    out.write_text("mine")

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pyarrow.csv.write_csv", full)
    with pytest.raises(UserError, match="No space left on device; nothing was written"):
        _export(store, "csv", out, replace=True)
    assert out.read_text() == "mine"
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == []


def test_a_folder_that_is_not_there(store, tmp_path):
    with pytest.raises(UserError, match="No such file or directory; nothing was written"):
        _export(store, "mcap", tmp_path / "no" / "x.mcap")
