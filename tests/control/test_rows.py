"""What control follows stays as it was when it was checked, whatever becomes of its file."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from pa10d.control.rows import rows_in, sealed

TABLE = np.arange(28 * 2000, dtype=float).reshape(2000, 28)


@pytest.fixture
def file(tmp_path):
    np.save(tmp_path / "rows.npy", TABLE)
    return tmp_path / "rows.npy"


def test_a_file_that_is_cut_off_meanwhile_ends_nobody(file):
    """Read from a map of the file, that is a SIGBUS."""
    memory = sealed(file)
    rows = rows_in(memory)
    os.close(memory)
    os.truncate(file, 4096)
    np.testing.assert_array_equal(rows, TABLE)
    mapped = (
        "import os, sys, numpy as np\n"
        "np.save(sys.argv[1], np.ones((2000, 28)))\n"
        "rows = np.load(sys.argv[1], mmap_mode='r')\n"
        "os.truncate(sys.argv[1], 4096)\n"
        "print(rows[-1])"
    )
    ended = subprocess.run([sys.executable, "-c", mapped, str(file)], capture_output=True)
    assert ended.returncode < 0, "or maps are safe here, and sealing is no longer needed"


def test_nobody_changes_what_was_taken(file):
    memory = sealed(file)
    with pytest.raises(PermissionError):
        os.truncate(memory, 4096)
    with pytest.raises(PermissionError):
        os.pwrite(memory, b"x", 200)
    with pytest.raises(ValueError, match="read-only"):
        rows_in(memory)[0, 0] = 1.0
    os.close(memory)


def test_what_can_still_be_changed_is_not_taken(file):
    with file.open("rb") as plain, pytest.raises(ValueError, match="can still be changed"):
        rows_in(plain.fileno())
    reading, writing = os.pipe()
    with pytest.raises(ValueError, match="can still be changed"):
        rows_in(reading)
    memory = os.memfd_create("rows", os.MFD_ALLOW_SEALING)
    os.write(memory, file.read_bytes())
    with pytest.raises(ValueError, match="can still be changed"):
        rows_in(memory)
    for one in (reading, writing, memory):
        os.close(one)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda data: data[:-8], "bytes of them are there"),
        (lambda data: data + b"x", "bytes of them are there"),
        (lambda data: b"", "magic|EOF"),
        (lambda data: data.replace(b"<f8", b"<f4"), "float64"),
        (lambda data: data.replace(b"(2000, 28)", b"(56000,)  "), "float64"),
        (lambda data: data.replace(b"(2000, 28)", b"(-200, 28)"), "bytes of them|negative"),
    ],
)
def test_what_is_no_table_of_rows_is_said(file, spoil, says):
    file.write_bytes(spoil(file.read_bytes()))
    memory = sealed(file)
    with pytest.raises(ValueError, match=says):
        rows_in(memory)
    os.close(memory)
