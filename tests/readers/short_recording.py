"""One short recording, and writers of it in the shapes that files have."""

from __future__ import annotations

import re
import shlex

import numpy as np
import pyarrow as pa
from pyarrow import parquet
from scipy.io import savemat

from pa10d.common.errors import UserError
from pa10d.readers import read_recording

N, RATE = 600, 200.0
T = np.arange(N) / RATE
Q = np.stack([0.8 * np.sin(3 * T), 0.6 * np.cos(2 * T)], axis=1)
DQ = np.stack([2.4 * np.cos(3 * T), -1.2 * np.sin(2 * T)], axis=1)
TAU = 5.0 * np.sin(3 * T)[:, None] * [1.0, 0.4] + 0.3 * Q
FLAT = {"q1": Q[:, 0], "q2": Q[:, 1], "tau1": TAU[:, 0], "tau2": TAU[:, 1]}
NS = np.rint(T * 1e9).astype(np.int64)
EPOCH = 1_700_000_000_250_000_000


def rows(columns, sign=","):
    return [sign.join(str(v) for v in row) for row in zip(*columns, strict=True)]


def text(name, columns, names, above=(), below=(), sign=","):
    def write(folder):
        made = [*above, sign.join(names), *below, *rows(columns, sign)]
        (folder / name).write_text("\n".join(made) + "\n")
        return folder / name

    return write


def table(**columns):
    def write(folder):
        parquet.write_table(pa.table(columns), folder / "run.parquet")
        return folder / "run.parquet"

    return write


def matlab(**content):
    def write(folder):
        savemat(folder / "run.mat", content)
        return folder / "run.mat"

    return write


def mapped(refusal):
    found = re.search(r"perhaps --map ([^;]+)", refusal)
    assert found, refusal
    return shlex.split(found[1])


def comes_in_right(path, robot):
    """By itself, or by the line that its refusal ends in."""
    try:
        found = read_recording(path, *robot)
    except UserError as error:
        found = read_recording(path, *robot, mapped(str(error)))
    np.testing.assert_allclose(found.samples.q, Q, atol=1e-6)
    np.testing.assert_allclose(found.samples.tau, TAU, atol=1e-5)
    np.testing.assert_allclose(np.diff(found.timing.grid), 0.005, atol=1e-6)
    if found.samples.dq is not None:
        np.testing.assert_allclose(found.samples.dq, DQ, atol=1e-6)
