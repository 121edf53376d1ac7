"""A folder in memory for what processes share, and who may own bus and data."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from pa10d.common.errors import UserError
from pa10d.common.locked_file import lock_at_once

PREFIX = "pa10d-run-"


@contextlib.contextmanager
def runtime_folder() -> Iterator[Path]:
    """A private folder in a memory file system, removed at the end; leftovers go first."""
    base = _base()
    for old in base.glob(f"{PREFIX}*"):
        pid = old.name.removeprefix(PREFIX).partition("-")[0]
        if pid.isdigit() and not Path(f"/proc/{pid}").exists():
            shutil.rmtree(old, ignore_errors=True)
    folder = Path(tempfile.mkdtemp(prefix=f"{PREFIX}{os.getpid()}-", dir=base))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def ring_of(pid: int) -> Path:
    """The ring of a running daemon, for tools that look at every cycle."""
    for folder in _base().glob(f"{PREFIX}{pid}-*"):
        return folder / "ring"
    raise UserError(f"process {pid}: no daemon of this machine shares a ring")


def _base() -> Path:
    for candidate in (os.environ.get("RUNTIME_DIRECTORY", "").partition(":")[0], "/dev/shm"):
        if candidate and os.access(candidate, os.W_OK):
            return Path(candidate)
    return Path(tempfile.gettempdir())


def own(path: Path, patience: float, taken: str) -> IO[str]:
    """Lock a file for as long as it is open, in this process and those that inherit it."""
    file = path.open("a")
    until = time.monotonic() + patience
    while True:
        if lock_at_once(file):
            return file
        if time.monotonic() > until:
            file.close()
            raise UserError(taken)
        time.sleep(0.1)
