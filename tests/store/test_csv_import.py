"""What a CSV recording may look like, and what becomes of it."""

from __future__ import annotations

import numpy as np
import pytest
from store_data import motion, plain_table, write_csv

from pa10d.common.errors import UserError
from pa10d.store.csv_import import read_csv


def _read(path, n=2, constants=None, mapping=()):
    return read_csv(path, n, "arm", constants, mapping)


@pytest.fixture
def table():
    return plain_table(*motion())


@pytest.mark.parametrize("name", ["a.csv", "a.csv.gz", "named.csv.GZ"])
def test_the_plain_file(tmp_path, table, name):
    path = write_csv(tmp_path / name, table)
    if name.endswith("GZ"):
        path = write_csv(tmp_path / "x.csv.gz", table).rename(tmp_path / name)
    found = _read(path)
    assert not found.timing.resampled
    assert found.header_warnings == found.timing_warnings == []
    np.testing.assert_array_equal(found.samples.q, np.stack([table["q1"], table["q2"]], axis=1))
    np.testing.assert_array_equal(found.samples.tau[:, 1], table["tau2"])
    np.testing.assert_array_equal(found.samples.stamps, np.rint(table["time"] * 1e9))
    assert found.samples.dq is None
    assert found.samples.extra == {}


def test_any_order_with_everything_optional(tmp_path, table):
    rng = np.random.default_rng(0)
    for name in ("dq1", "dq2", "i1", "i2", "temp1", "temp2", "qse1", "phase"):
        table[name] = rng.normal(size=400)
    names = list(table)
    rng.shuffle(names)
    found = _read(write_csv(tmp_path / "a.csv", {name: table[name] for name in names}))
    for block, prefix in (("dq", "dq"), ("current", "i"), ("temperature", "temp"), ("tau", "tau")):
        expected = np.stack([table[f"{prefix}1"], table[f"{prefix}2"]], axis=1)
        np.testing.assert_array_equal(getattr(found.samples, block), expected)
    assert set(found.samples.extra) == {"qse1", "phase"}
    np.testing.assert_array_equal(found.samples.extra["phase"], table["phase"])


def test_windows_line_ends_byte_order_mark_quotes_and_blanks(tmp_path, table):
    path = write_csv(tmp_path / "a.csv", table)
    lines = path.read_text().splitlines()
    lines[0] = ", ".join(f'"{name}"' if name == "q1" else name for name in table)
    lines.insert(7, "")
    path.write_bytes(("\ufeff" + "\r\n".join(lines) + "\r\n\r\n").encode())
    found = _read(path)
    np.testing.assert_array_equal(found.samples.q[:, 0], table["q1"])


def test_columns_are_mapped(tmp_path, table):
    renamed = {"Time [s]": table["time"], "a=b": table["q1"]}
    renamed |= {name: table[name] for name in ("q2", "tau1", "tau2")}
    path = write_csv(tmp_path / "a.csv", renamed)
    found = _read(path, mapping=["Time [s]=time", "a=b=q1"])
    np.testing.assert_array_equal(found.samples.q[:, 0], table["q1"])


def test_current_stands_in_where_torque_is_absent(tmp_path, table):
    del table["tau2"]
    table["i2"] = np.linspace(-1, 1, 400)
    path = write_csv(tmp_path / "a.csv", table)
    found = _read(path, constants=[5.0, -7.0])
    np.testing.assert_allclose(found.samples.tau[:, 1], -7.0 * table["i2"])
    np.testing.assert_array_equal(found.samples.tau[:, 0], table["tau1"])
    with pytest.raises(UserError, match=r"no column tau2; .*torque_constants"):
        _read(path)


def test_torque_wins_over_current(tmp_path, table):
    table |= {"i1": np.ones(400), "i2": np.ones(400)}
    found = _read(write_csv(tmp_path / "a.csv", table), constants=[5.0, 5.0])
    np.testing.assert_array_equal(found.samples.tau[:, 0], table["tau1"])
    np.testing.assert_array_equal(found.samples.current, np.ones((400, 2)))


def test_joints_beyond_the_robot_s_are_kept_with_a_warning(tmp_path, table):
    found = _read(write_csv(tmp_path / "a.csv", table), n=1)
    assert found.samples.q.shape == (400, 1)
    assert set(found.samples.extra) == {"q2", "tau2"}
    assert all("beyond the 1 joint of arm" in w for w in found.header_warnings)


def test_dq_of_some_joints_only_is_kept_aside(tmp_path, table):
    table["dq1"] = np.zeros(400)
    found = _read(write_csv(tmp_path / "a.csv", table))
    assert found.samples.dq is None
    assert set(found.samples.extra) == {"dq1"}
    assert "dq1 without dq of every joint" in found.header_warnings[0]


def test_text_and_holes_in_extra_columns_do_no_harm(tmp_path, table):
    table |= {"label": ["slow"] * 400, "sparse": [""] * 399 + ["2.5"], "flag": ["true"] * 400}
    found = _read(write_csv(tmp_path / "a.csv", table))
    assert "no numbers in label: left out" in found.header_warnings[0]
    assert set(found.samples.extra) == {"sparse", "flag"}
    sparse = found.samples.extra["sparse"]
    assert np.isnan(sparse[:-1]).all()
    assert sparse[-1] == 2.5
    np.testing.assert_array_equal(found.samples.extra["flag"], 1.0)


@pytest.mark.parametrize("kind", ["dq", "temp", "i"])
@pytest.mark.parametrize("hole", ["", "nan", "inf"])
def test_holes_in_what_need_not_be_there_lose_nothing(tmp_path, table, kind, hole):
    for name in (f"{kind}1", f"{kind}2"):
        table[name] = ["0.5"] * 400
    table[f"{kind}2"][100:103] = [hole] * 3
    found = _read(write_csv(tmp_path / "a.csv", table))
    [said] = found.header_warnings
    assert f"3 cells of {kind}2 are no finite numbers" in said
    assert found.samples.dq is found.samples.temperature is found.samples.current is None
    assert set(found.samples.extra) == {f"{kind}1", f"{kind}2"}
    assert not np.isfinite(found.samples.extra[f"{kind}2"][100:103]).any()
    np.testing.assert_array_equal(found.samples.q[:, 1], table["q2"])


def test_a_hole_in_the_only_measure_of_torque_is_refused(tmp_path, table):
    for j in (1, 2):
        del table[f"tau{j}"]
        table[f"i{j}"] = ["0.5"] * 400
    table["i2"][100] = "nan"
    with pytest.raises(UserError, match=r":102: column \d+ \(i2\): found 'nan'"):
        _read(write_csv(tmp_path / "a.csv", table), constants=(1.0, 2.0))


def test_an_extra_column_that_turns_to_text_late_is_left_out(tmp_path):
    table = plain_table(*motion(60_000))
    table["note"] = ["1"] * 59_999 + ["end"]
    found = _read(write_csv(tmp_path / "a.csv", table))
    assert "note" not in found.samples.extra
    assert len(found.samples) == 60_000


def test_irregular_stamps_are_resampled_and_it_is_said(tmp_path, table):
    rng = np.random.default_rng(1)
    t = table["time"] + rng.uniform(-1e-3, 1e-3, 400)
    phase = t[:, None] * [1, 2]
    table |= {"time": t, "q1": np.sin(phase[:, 0]), "q2": np.sin(phase[:, 1])}
    found = _read(write_csv(tmp_path / "a.csv", table))
    assert "the stamps are irregular" in found.timing_warnings[0]
    assert "interpolated at 200 Hz" in found.timing_warnings[0]
    grid = found.samples.stamps * 1e-9
    np.testing.assert_allclose(np.diff(grid), 0.005, atol=2e-9)
    assert np.abs(found.samples.q[:, 1] - np.sin(2 * (grid + min(0, t[0])))).max() < 1e-5


def test_duplicate_stamps_are_merged_and_it_is_said(tmp_path, table):
    table["time"] = table["time"].copy()
    table["time"][100] = table["time"][99]
    found = _read(write_csv(tmp_path / "a.csv", table))
    assert "1 samples share a stamp" in found.timing_warnings[0]
    mean = 0.5 * (table["tau1"][99] + table["tau1"][100])
    np.testing.assert_allclose(found.samples.tau[99, 0], mean)


def test_a_gap_is_filled_marked_and_said(tmp_path, table):
    table["time"] = np.where(np.arange(400) < 200, table["time"], table["time"] + 1.5)
    found = _read(write_csv(tmp_path / "a.csv", table))
    assert any("a gap without samples, 1.5" in w for w in found.timing_warnings)
    marked = found.samples.extra["gap"]
    assert marked.sum() == pytest.approx(1.5 * 200, abs=2)


def test_negative_times_are_kept_by_a_shift(tmp_path, table):
    table["time"] = table["time"] - 1.25
    found = _read(write_csv(tmp_path / "a.csv", table))
    assert found.time_zero_ns == 1_250_000_000
    assert found.samples.stamps[0] == 0


def test_seconds_since_1970(tmp_path, table):
    table["time"] = table["time"] + 1_763_700_000.0
    found = _read(write_csv(tmp_path / "a.csv", table))
    assert not found.timing.resampled
    assert found.samples.stamps[0] == pytest.approx(1.7637e18, abs=300)
    assert found.timing.rate == pytest.approx(200, rel=1e-6)
