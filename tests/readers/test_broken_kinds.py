"""Files that somebody might have, each broken in its own way: one line that names the file."""

from __future__ import annotations

import bz2
import gzip
import io
import json
import zipfile

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from pa10d.common.errors import UserError
from pa10d.readers import read_recording
from pa10d.services.robots import load_robot

ROWS = 150
T = np.arange(ROWS) * 0.01
Q = np.sin(np.outer(T, np.arange(1, 7)))


def table(delimiter=";", names=None, change=None, end="\n"):
    names = names or ["time", *(f"q{j}" for j in range(1, 7)), *(f"tau{j}" for j in range(1, 7))]
    rows = [[repr(float(v)) for v in row] for row in np.column_stack([T, Q, 10 * Q])]
    if change:
        change(rows)
    return (delimiter.join(names) + end + end.join(map(delimiter.join, rows)) + end).encode()


def cell(row, column, text):
    def change(rows):
        rows[row][column] = text

    return change


def npz(**blocks):
    file = io.BytesIO()
    np.savez(file, **blocks)
    return file.getvalue()


def parquet(**blocks):
    import pyarrow as pa
    from pyarrow import parquet as format

    file = io.BytesIO()
    format.write_table(pa.table(blocks), file)
    return file.getvalue()


def mat(**blocks):
    from scipy.io import savemat

    file = io.BytesIO()
    savemat(file, blocks)
    return file.getvalue()


def swapped(rows):
    rows[3], rows[4] = rows[4], rows[3]


def nan(block):
    block = block.copy()
    block[7, 2] = np.nan
    return block


NO_TIME = ["t0", *(f"q{j}" for j in range(1, 7)), *(f"tau{j}" for j in range(1, 7))]
TWICE = ["time", *(["q1"] * 6), *(f"tau{j}" for j in range(1, 7))]
BROKEN = {
    "only blanks": (b"   \n \n", "run.csv", ""),
    "only comments": (b"# a\n# b\n", "run.csv", "an empty file"),
    "a header alone": (table().splitlines()[0] + b"\n", "run.tsv", ""),
    "a header alone, commas": (table(",").splitlines()[0] + b"\n", "run.csv", "found 0 samples"),
    "too few rows": (b"\n".join(table().splitlines()[:20]), "run.csv", "found 19 samples"),
    "no time": (table(names=NO_TIME), "run.csv", "no column time"),
    "no time, commas": (table(",", NO_TIME), "run.csv", "no column time"),
    "a name twice": (table(",", TWICE), "run.csv", "q1"),
    "a joint too few": (
        table(",", NO_TIME).replace(b"t0", b"time").replace(b"q6", b"z6"),
        "run.csv",
        "q6",
    ),
    "stamps that fall": (table(change=swapped), "run.csv", "expected stamps that rise"),
    "stamps that fall, commas": (table(",", change=swapped), "run.csv", ":6: column time"),
    "an infinity": (table(",", change=cell(9, 3, "inf")), "run.csv", ":11: column 4"),
    "a hole": (table(",", change=cell(9, 3, "")), "run.csv", ":11: column 4"),
    "not a number": (table(change=cell(9, 3, "nan")), "run.csv", "column q3: sample 10 is nan"),
    "two points": (table(change=cell(9, 3, "1.2.3")), "run.csv", ":11: column 4"),
    "a cell too many": (table(change=cell(9, 3, "1;2")), "run.csv", ":11: found 14 columns"),
    "an open quote": (table(",", change=cell(9, 3, '"1')), "run.csv", "run.csv"),
    "zeros behind": (table(",") + bytes(500), "run.csv", "run.csv"),
    "packed twice": (gzip.compress(gzip.compress(table())), "run.csv.gz", ""),
    "a bz2 that ends": (bz2.compress(table())[:-20], "run.csv.bz2", "damaged"),
    "a gz with noise": (gzip.compress(table())[:50] + b"noise" * 30, "run.tsv", "damaged"),
    "a csv.gz with noise": (gzip.compress(table(","))[:50] + b"noise" * 30, "run.csv.gz", ""),
    "a zst that is none": (b"\x28\xb5\x2f\xfd" + bytes(60), "run.csv.zst", ""),
    "npz without time": (npz(q=Q, tau=Q), "run.npz", "no column time"),
    "npz of other lengths": (npz(time=T, q=Q[:90], tau=Q), "run.npz", "q1"),
    "npz with nan": (npz(time=T, q=nan(Q), tau=Q), "run.npz", "column q3: sample 8 is nan"),
    "npz of objects": (
        npz(time=T, q=np.array([{}, {}], dtype=object)),
        "run.npz",
        "cannot be read",
    ),
    "npz of a scalar": (npz(time=3.0), "run.npz", ""),
    "npz of too few joints": (npz(time=T, q=Q[:, :4], tau=Q), "run.npz", "q5"),
    "parquet without torque": (parquet(time=T, q1=Q[:, 0]), "run.parquet", ""),
    "parquet of text": (parquet(time=["a"] * ROWS), "run.parquet", ""),
    "parquet that ends": (parquet(time=T)[:-30], "run.parquet", "cannot be read"),
    "mat without anything": (mat(), "run.mat", ""),
    "mat of text": (mat(time="now"), "run.mat", ""),
    "mat that ends": (mat(time=T, q=Q, tau=Q)[:-2000], "run.mat", ""),
    "mat with still stamps": (mat(time=T * 0, q=Q, tau=Q), "run.mat", "one stamp"),
    "a picture as a bag": (b"\xff\xd8\xff\xe0" + bytes(300), "run.mcap", "run.mcap"),
    "a database of others": (b"SQLite format 3\0" + bytes(4080), "run.db3", "cannot be read"),
    "an asc without frames": (b"date Sun Nov 1 10:00:00 2026\nbase hex\n" * 9, "run.asc", ""),
    "an empty line by a record separator": (b"time;q1\n\x1e\xc0\x8fcQ", "run.txt", ""),
    "a pdf": (b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n" + bytes(300), "run.pdf", ""),
    "json": (json.dumps({"q": [1, 2]}).encode(), "run.json", ""),
}


@pytest.fixture(scope="module")
def arm():
    return load_robot("ur5e")


def test_there_are_enough_of_them():
    assert len(BROKEN) >= 40


@pytest.mark.parametrize("kind", BROKEN)
def test_it_is_one_line_that_names_the_file(kind, tmp_path, arm):
    content, name, says = BROKEN[kind]
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(UserError) as caught:
        read_recording(path, *arm)
    message = str(caught.value)
    assert str(path) in message
    assert "\n" not in message
    assert "expected" in message or ", " in message
    assert says in message
    assert len(message) < 700


def hdf5_of_nothing(path):
    with h5py.File(path, "w") as file:
        for name in ("time", "q1", "tau1"):
            file.create_dataset(name, (10**8,), "f8", chunks=(1 << 20,), compression="gzip")


def npz_that_claims(path):
    header = io.BytesIO()
    shape = {"descr": "<f8", "fortran_order": False, "shape": (10**15,)}
    np.lib.format.write_array_header_1_0(header, shape)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("time.npy", header.getvalue() + bytes(80))


ZEROS = np.zeros(9_000_000)  # 72 MB


@pytest.mark.parametrize(
    ("name", "write", "says"),
    [
        ("a.h5", hdf5_of_nothing, "bytes of numbers"),
        ("a.npz", npz_that_claims, "Unable to allocate"),
        ("b.npz", lambda path: np.savez_compressed(path, time=ZEROS), "bytes of numbers"),
        ("a.mat", lambda path: savemat(path, {"t": ZEROS}, do_compression=True), "bytes of nu"),
        ("a.parquet", lambda path: path.write_bytes(parquet(time=ZEROS)), "bytes of numbers"),
    ],
)
def test_a_small_file_that_fills_the_memory_is_refused(tmp_path, name, write, says):
    profile, robot = load_robot("ur5e")
    write(tmp_path / name)
    assert (tmp_path / name).stat().st_size < 300_000
    with pytest.raises(UserError, match=says) as caught:
        read_recording(tmp_path / name, profile, robot)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("way", ["external", "virtual"])
def test_a_recording_reads_no_other_file_of_this_machine(tmp_path, way):
    """What somebody sends by HTTP would come back as a column of numbers."""
    profile, robot = load_robot("ur5e")
    secret = tmp_path / "secret"
    with h5py.File(secret, "w") as file:
        file["time"] = np.arange(100.0)
    with h5py.File(tmp_path / "sent.h5", "w") as file:
        if way == "external":
            file.create_dataset("time", (100,), "u1", external=[(str(secret), 0, 100)])
        else:
            layout = h5py.VirtualLayout((100,), "f8")
            layout[:] = h5py.VirtualSource(str(secret), "time", (100,))
            file.create_virtual_dataset("time", layout)
    with pytest.raises(UserError, match="time: its values lie in another file"):
        read_recording(tmp_path / "sent.h5", profile, robot)
