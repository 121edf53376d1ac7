"""Rows of a planned motion in sealed memory: what control has checked, nobody shortens or changes.

A file can be cut off while it is read from a map of it, and that ends a process (SIGBUS). Copying
it takes tens of milliseconds a minute of motion, too long beside a loop. So the daemon copies, and
control takes the copy only with the kernel's word that it stays as it is.
"""

from __future__ import annotations

import fcntl
import mmap
import os
import stat
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_WRITE
PIECE = 1 << 24  # bytes


def sealed(path: Path) -> int:
    """A copy of a file of ours in memory that nothing changes any more: its descriptor, to be
    closed by whoever asked."""
    memory = os.memfd_create("pa10d-rows", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    try:
        with path.open("rb") as file:
            while piece := file.read(PIECE):
                _write(memory, piece)
        fcntl.fcntl(memory, fcntl.F_ADD_SEALS, SEALS)
    except BaseException:
        os.close(memory)
        raise
    return memory


def rows_in(memory: int) -> Array:
    """The table (N, …) that such a copy holds, paged in as it is read; ValueError for another."""
    if not stat.S_ISREG(os.fstat(memory).st_mode) or not _is_sealed(memory):
        raise ValueError("its rows can still be changed, expected sealed memory")
    with os.fdopen(os.dup(memory), "rb") as file:
        file.seek(0)
        if np.lib.format.read_magic(file) != (1, 0):
            raise ValueError("its rows are of another version of .npy, expected 1.0")
        shape, turned, dtype = np.lib.format.read_array_header_1_0(file)
        if turned or dtype != np.float64 or len(shape) != 2:
            raise ValueError(f"its rows are {shape} {dtype}, expected (N, …) float64 by rows")
        begin, size = file.tell(), os.fstat(memory).st_size
    if begin + 8 * shape[0] * shape[1] != size:
        raise ValueError(f"its rows are {shape}, but {size - begin} bytes of them are there")
    held = mmap.mmap(memory, size, flags=mmap.MAP_PRIVATE, prot=mmap.PROT_READ)
    return np.frombuffer(held, np.float64, shape[0] * shape[1], begin).reshape(shape)


def _is_sealed(memory: int) -> bool:
    try:
        return fcntl.fcntl(memory, fcntl.F_GET_SEALS) & SEALS == SEALS
    except OSError:  # of a file on a disk
        return False


def _write(memory: int, piece: bytes) -> None:
    left = memoryview(piece)
    while left:
        left = left[os.write(memory, left) :]
