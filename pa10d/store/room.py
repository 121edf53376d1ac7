"""Room on the disk: looked at before a run begins, and kept in reserve for its end."""

from __future__ import annotations

import contextlib
import os
import shutil
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.store.channels import Channels
from pa10d.store.mcap_records import MESSAGE_HEAD

INDEX = 16  # bytes of a message in its index
SPARE = 32 << 20  # bytes that a run leaves free for what is done with it
FILE, RESERVE = ".reserve", 1 << 20  # by which a run is closed on a disk that is full


def free(folder: Path) -> int:
    """Bytes that may still be written."""
    return shutil.disk_usage(folder).free


def size_of_run(channels: Channels, samples: int) -> int:
    """Bytes of the bag."""
    messages = [len(template.cdr) for template, _ in channels.templates().values()]
    return samples * sum(size + MESSAGE_HEAD.size + INDEX for size in messages) + RESERVE


def shortage(folder: Path, needed: int) -> str | None:
    """What is wrong with the room for ``needed`` bytes."""
    there = free(folder)
    if there >= needed + SPARE:
        return None
    return (
        f"{folder}: {_mega(there)} are free, the run needs {_mega(needed)} and "
        f"{_mega(SPARE)} to spare"
    )


def refuse_without_room(folder: Path, needed: int) -> None:
    """UserError before anything is written."""
    if (said := shortage(folder, needed)) is not None:
        raise UserError(f"{said}; delete runs, or expect a data folder on a larger disk (--data)")


def reserve(folder: Path) -> None:
    """Take room that ``give_back`` can give; some file systems cannot, and go without."""
    descriptor = os.open(folder / FILE, os.O_WRONLY | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        with contextlib.suppress(OSError):
            os.posix_fallocate(descriptor, 0, RESERVE)
    finally:
        os.close(descriptor)


def give_back(folder: Path) -> None:
    """The reserve is free again."""
    with contextlib.suppress(OSError):
        (folder / FILE).unlink(missing_ok=True)


def _mega(size: int) -> str:
    return f"{size / 1e6:.0f} MB"
