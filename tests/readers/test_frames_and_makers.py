"""What data frames and makers' own tools write: right by itself or by the line of its refusal, or
one clear line that says what to do."""

from __future__ import annotations

import csv
import zipfile

import numpy as np
import pytest
from short_recording import DQ, EPOCH, FLAT, NS, TAU, N, Q, T, comes_in_right, matlab, text
from test_formats import JOINTS

from pa10d.common.errors import UserError
from pa10d.readers import read_recording
from pa10d.store.column_guess import guess

SECOND = 10**9


def frame(*rows):
    """As a data frame writes itself: quoted where there is a comma."""

    def write(folder):
        with (folder / "run.csv").open("w", newline="") as file:
            csv.writer(file).writerows(rows)
        return folder / "run.csv"

    return write


def stamps(k):
    """As an index of dates is written."""
    whole, rest = divmod(int(NS[k]), SECOND)
    return f"2026-03-01 12:00:{whole:02d}.{rest:09d}"


def since_start(k):
    whole, rest = divmod(int(NS[k]), SECOND)
    return f"0 days 00:00:{whole:02d}.{rest:09d}"


def numbered(first, *blocks):
    return [[first(k), *(float(v) for block in blocks for v in block[k])] for k in range(N)]


def seconds(k):
    return float(T[k])


def vectors(show):
    return frame(
        ["timestamp", "name", "position", "effort"],
        *([T[k], str(list(JOINTS[::-1])), show(Q[k, ::-1]), show(TAU[k, ::-1])] for k in range(N)),
    )


def by_a_desktop(folder):
    with zipfile.ZipFile(folder / "run.zip", "w") as archive:
        rows = [",".join(map(str, row)) for row in numbered(seconds, Q, TAU)]
        archive.writestr("Run 1/run.csv", "\n".join(["time,q1,q2,tau1,tau2", *rows]))
        archive.writestr("__MACOSX/Run 1/._run.csv", b"\0\5\x16\7")
        archive.writestr("Run 1/.DS_Store", b"\0")
    return folder / "run.zip"


def numpy(**blocks):
    def write(folder):
        np.savez(folder / "run.npz", **blocks)
        return folder / "run.npz"

    return write


DEGREES = [np.degrees(Q[:, 0]), np.degrees(Q[:, 1]), TAU[:, 0], TAU[:, 1]]
NAMED = ["name_0", "name_1", "position_0", "position_1", "effort_0", "effort_1"]
WHOLE = {
    "an index of dates": frame(["", *FLAT], *numbered(stamps, Q, TAU)),
    "an index of durations": frame(["", *FLAT], *numbered(since_start, Q, TAU)),
    "levels of columns": frame(
        ["", "q", "q", "tau", "tau"], ["", *JOINTS, *JOINTS], ["time", "", "", "", ""],
        *numbered(seconds, Q, TAU),
    ),
    "lists in cells": vectors(lambda row: str(row.tolist())),
    "lists of NumPy's numbers": vectors(lambda row: str([f"np.float64({v!r})" for v in
                                                         row.tolist()]).replace("'", "")),
    "arrays in cells": vectors(lambda row: np.array2string(row, precision=17)),
    "joints named in columns": frame(
        ["Time", *NAMED],
        *([EPOCH / SECOND + T[k], *JOINTS[::-1], *Q[k, ::-1], *TAU[k, ::-1]] for k in range(N)),
    ),
    "packed by a desktop": by_a_desktop,
    "ns since 1970 by another name": text(
        "run.csv", [NS + EPOCH, *FLAT.values()],
        ["stamp", "position[0]", "position[1]", "effort[0]", "effort[1]"],
    ),
    "axes and units alone": text(
        "run.csv", [T * 1e3, *DEGREES], ["Zeit [ms]", "A1 [°]", "A2 [°]", "M1 [Nm]", "M2 [Nm]"],
    ),
    "bare axes": text("run.csv", [T, *FLAT.values()], ["TIME", "J1", "J2", "TRQ1", "TRQ2"]),
    "actual positions": text(
        "run.txt", [T, *FLAT.values()], sign="\t",
        names=["Time", "Axis 1.ActPos", "Axis 2.ActPos", "Axis 1.ActTorque", "Axis 2.ActTorque"],
    ),
    "a simulator's names": numpy(ts=T, qpos=Q, qvel=DQ, qfrc_actuator=TAU, qfrc_passive=0 * TAU),
    "Simulink's clock": matlab(tout=T[:, None], theta=Q, thetad=DQ, torque=TAU),
}  # fmt: skip


@pytest.mark.parametrize("kind", WHOLE)
def test_right_by_itself_or_by_the_line_of_its_refusal(tmp_path, robot, kind):
    comes_in_right(WHOLE[kind](tmp_path), robot)


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        ("level{n} [m]", ()),
        ("J{n} pitch [°/s]", ("dq",)),
        ("qfrc_bias{n}", ()),
        ("T{n} [Nm]", ("tau",)),
    ],
)
def test_a_unit_tells_only_what_no_word_does(name, fields):
    rules = guess([name.replace("{n}", str(j)) for j in (1, 2)], 2)
    assert rules == [f"{name}={field}" for field in fields]


def changing(folder):
    rows = ([T[k], *(JOINTS if k < 300 else JOINTS[::-1]), *Q[k], *TAU[k]] for k in range(N))
    return frame(["time", *NAMED], *rows)(folder)


def shorter(folder):
    rows = ([T[k], str(Q[k].tolist()), str(TAU[k, : 1 + (k != 7)].tolist())] for k in range(N))
    return frame(["time", "q", "tau"], *rows)(folder)


def content(name, said):
    def write(folder):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(said)
        return folder / name.split("/")[0]

    return write


def tables(folder):
    for name in ("a.csv", "b.csv"):
        (folder / "runs").mkdir(exist_ok=True)
        (folder / "runs" / name).write_text("time,q1\n")
    return folder / "runs"


def hdf_of_pandas(folder):
    h5py = pytest.importorskip("h5py", reason="no h5py for HDF5")
    with h5py.File(folder / "run.h5", "w") as file:
        group = file.create_group("log")
        group.attrs["pandas_type"] = np.bytes_("frame")
        group["block0_values"] = np.column_stack([Q, TAU])
    return folder / "run.h5"


POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"
REFUSED = {
    "names that change": (changing, "row 301 names elbow, the first shoulder; expected one order"),
    "a cell with fewer": (shorter, "column tau: sample 8 has 1 values, the first 2; expected as"),
    "a pointer": (content("run.csv", POINTER), "pointer to a recording; expected .* git lfs pull"),
    "a pointer in Parquet's place": (content("run.parquet", POINTER), "by git lfs pull"),
    "a pointer in a bag": (content("bag/bag_0.db3", POINTER), "bag_0.db3: .* by git lfs pull"),
    "a web page": (content("run.csv", b"<!DOCTYPE html>\n<html>404</html>\n"), "a web page; exp"),
    "a folder of tables": (tables, "no bag file; found a.csv, b.csv; expected .* or one file"),
    "a data frame in HDF5": (hdf_of_pandas, r"read_hdf\(…\).to_parquet\(…\)"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_one_clear_line(tmp_path, robot, kind):
    write, told = REFUSED[kind]
    path = write(tmp_path)
    with pytest.raises(UserError, match=told) as caught:
        read_recording(path, *robot)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
