"""Tables as data frames, MATLAB and loggers really leave them: the right arrays, or one line."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pyarrow as pa
import pytest
from scipy import sparse
from scipy.io import savemat
from short_recording import FLAT, NS, TAU, N, Q, T, matlab, table
from test_formats import lines

from pa10d.checks import unit_of_stamps
from pa10d.common.errors import UserError
from pa10d.readers import read_recording
from pa10d.services.import_preview import preview_recording


def hdf5_records(folder):
    h5py = pytest.importorskip("h5py", reason="no h5py for HDF5")
    rows = np.zeros(N, [("time", "f8"), *((name, "f8") for name in FLAT)])
    for name, values in {"time": T, **FLAT}.items():
        rows[name] = values
    with h5py.File(folder / "run.h5", "w") as file:
        file["log"] = rows
    return folder / "run.h5"


def old_mac(folder):
    (folder / "run.csv").write_bytes(lines({"time": T, **FLAT}).replace("\n", "\r").encode())
    return folder / "run.csv"


def numpy(**blocks):
    def write(folder):
        np.savez(folder / "run.npz", **blocks)
        return folder / "run.npz"

    return write


def decimals(values):
    return pa.array([Decimal(f"{v:.12f}") for v in values])


def holed(k):
    return pa.array([None if i == k else list(row) for i, row in enumerate(Q)])


WHOLE = {
    "stamps as the index": table(
        **FLAT, __index_level_0__=pa.array(NS + 10**18).cast(pa.timestamp("ns"))
    ),
    "time since the start": table(time=pa.array(NS).cast(pa.duration("ns")), **FLAT),
    "microseconds of a zone": table(
        time=pa.array(NS // 1000 + 10**15).cast(pa.timestamp("us", tz="UTC")), **FLAT
    ),
    "decimals": table(time=T, **{name: decimals(values) for name, values in FLAT.items()}),
    "large lists": table(
        time=T, q=pa.array(Q.tolist(), pa.large_list(pa.float64())), tau=pa.array(TAU.tolist())
    ),
    "rows for columns": matlab(time=T[None], q=Q.T, tau=TAU.T),
    "records in HDF5": hdf5_records,
    "lines of an old Mac": old_mac,
    "NumPy's dates": numpy(
        time=np.datetime64("2026-01-01T00:00:00.25", "ns") + NS.astype("m8[ns]"), q=Q, tau=TAU
    ),
    "the other end first": numpy(time=T.astype(">f8"), q=Q.astype(">f8"), tau=TAU.astype(">f8")),
}


@pytest.mark.parametrize("kind", WHOLE)
def test_the_right_arrays(tmp_path, robot, kind):
    found = read_recording(WHOLE[kind](tmp_path), *robot)
    np.testing.assert_allclose(found.samples.q, Q, atol=1e-11)
    np.testing.assert_allclose(found.samples.tau, TAU, atol=1e-11)
    np.testing.assert_allclose(np.diff(found.timing.grid), 0.005, atol=1e-9)


REFUSED = {
    "numbers in words": (
        table(time=T, **{name: [str(v) for v in values] for name, values in FLAT.items()}),
        r"no column q1.*no numbers in q1 \(string\)",
    ),
    "a row with fewer": (
        table(time=T, q=[list(r) if k != 7 else [1.0] for k, r in enumerate(Q)], tau=TAU.tolist()),
        r"column q: row 8 has 1 values, expected as many in every row",
    ),
    "a row of nothing": (
        table(time=T, q=holed(7), tau=TAU.tolist()), r"column q: row 8 has none, expected as many",
    ),
    "a first row of nothing": (
        table(time=T, q=holed(0), tau=TAU.tolist()), r"column q: row 1 has none, expected as many",
    ),
    "a stamp of nothing": (
        table(time=pa.array([None if k == 9 else int(v) for k, v in enumerate(NS)], pa.int64())
              .cast(pa.timestamp("ns")), **FLAT),
        r"column time: sample 10 is nan",
    ),
    "sparse": (matlab(time=T, q=sparse.csc_matrix(Q), tau=TAU), r"no plain numbers in q \(sparse"),
    "complex": (matlab(time=T, q=Q + 0j, tau=TAU), r"no plain numbers in q \(complex"),
    "stamps of three seconds": (
        numpy(time=np.floor(T), q=Q, tau=TAU), r"found 3 different stamps, expected at least 100",
    ),
    "one row short": (numpy(time=T, q=Q[:-1], tau=TAU), r"q has 599 x 2 numbers for 600 samples"),
    "joints from 0, one too many": (
        numpy(time=T, q0=Q[:, 0], q1=Q[:, 1], q2=Q[:, 0], tau1=TAU[:, 0], tau2=TAU[:, 1]),
        r"q0 … q2 are 3 joints counted from 0, the robot has 2; expected --map 'q\{n-1\}=q'",
    ),
    "episodes in words": (
        table(episode_index=["a"] * N, timestamp=T, **FLAT), r"episode_index: expected whole",
    ),
    "episodes of nothing": (
        table(episode_index=pa.array([None] * N, pa.int64()), **FLAT), r"episode_index: expected",
    ),
    "a pause of an age": (
        numpy(time=np.append(T[:-1], 1e9), q=Q, tau=TAU), r"run.npz: .*expected one recording",
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_one_clear_line(tmp_path, robot, kind):
    write, told = REFUSED[kind]
    path = write(tmp_path)
    with pytest.raises(UserError, match=told) as caught:
        read_recording(path, *robot)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_time_in_days_is_told(tmp_path, robot):
    assert unit_of_stamps(200 * 86_400.0) == "day"
    assert unit_of_stamps(30_000.0) is None
    path = matlab(time=738_000 + T / 86_400, q=Q, tau=TAU)(tmp_path)
    found = preview_recording(path, *robot, thorough=False)
    assert found.problem == ""
    assert found.rules == ["time[day]=time"]
    assert found.rate == pytest.approx(200, rel=0.1)  # days of 2026 are kept to 10 µs


def test_joints_from_0_by_a_mapping(tmp_path, robot):
    write = numpy(time=T, q0=Q[:, 0], q1=Q[:, 1], q2=Q[:, 0], tau1=TAU[:, 0], tau2=TAU[:, 1])
    found = read_recording(write(tmp_path), *robot, ["q{n-1}=q"])
    np.testing.assert_array_equal(found.samples.q, Q)


@pytest.mark.parametrize(
    "rules", [["t=time"], ["t[ms]=time", "current1[2*A]=i1"], ["time[ms]=time", "i1=i1"], []]
)
def test_a_block_is_mapped_by_its_files_name_and_by_ours(tmp_path, robot, rules):
    """An array 't' is read as 'time': a rule for 't' was told that there is no such column."""
    scale = 1000.0 if "[ms]" in "".join(rules) else 1.0
    path = matlab(t=T * scale, q=Q, tau=TAU, current=Q)(tmp_path)
    found = read_recording(path, *robot, rules)
    since = (found.samples.stamps - found.samples.stamps[0]) * 1e-9
    np.testing.assert_allclose(since, T, atol=1e-6)


def numpy_file(folder, content):
    np.savez(folder / "run.npz", **content)
    return folder / "run.npz"


def matlab_file(folder, content):
    savemat(folder / "run.mat", {**content, "joint_names": content["joint_names"].astype(object)})
    return folder / "run.mat"


def hdf5_file(folder, content):
    h5py = pytest.importorskip("h5py", reason="no h5py for HDF5")
    with h5py.File(folder / "run.h5", "w") as file:
        for name, values in content.items():
            file[name] = values.astype(object) if values.dtype.kind == "U" else values
    return folder / "run.h5"


@pytest.mark.parametrize("write", [numpy_file, matlab_file, hdf5_file])
def test_names_of_joints_beside_the_arrays_order_their_columns(tmp_path, robot, write):
    content = {"time": T, "q": Q[:, ::-1], "tau": TAU[:, ::-1]}
    path = write(tmp_path, {**content, "joint_names": np.array(["elbow", "shoulder"])})
    found = read_recording(path, *robot)
    np.testing.assert_array_equal(found.samples.q, Q)
    np.testing.assert_array_equal(found.samples.tau, TAU)
    assert "in the order elbow, shoulder: dealt out by their names" in found.header_warnings[0]


def test_names_of_others_beside_the_arrays_are_told(tmp_path, robot):
    path = numpy_file(tmp_path, {"time": T, "q": Q, "tau": TAU, "names": np.array(["j2", "j1"])})
    found = read_recording(path, *robot)
    np.testing.assert_array_equal(found.samples.q, Q)
    assert "joints are called j2, j1: taken in this order" in found.header_warnings[0]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({"tau": 1e154 * TAU}, "column tau1: sample . is .*, expected a finite number of no more"),
        ({"tau": 1e-300 * TAU}, "the torque of joint 1 is .*e-300 N·m at most"),
    ],
)
def test_numbers_that_no_sensor_says_are_refused(tmp_path, robot, content, says):
    path = numpy_file(tmp_path, {"time": T, "q": Q, "tau": TAU, **content})
    with pytest.raises(UserError, match=says):
        read_recording(path, *robot)


def test_arrays_of_three_dimensions_are_told(tmp_path, robot):
    path = tmp_path / "run.npz"
    np.savez(path, time=T, q=Q[None] * np.ones((3, 1, 1)), tau=TAU)
    with pytest.raises(UserError, match=r"q has 3 x 600 x 2 numbers for 600 samples: left out"):
        read_recording(path, *robot)
