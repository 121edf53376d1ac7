"""A disk that does not take what is to be stored: told with its place, and what to do."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path

from pa10d.common.errors import NoRoom

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
OF_THE_DISK = (*FULL, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO)
IN_MEMORY = (
    "expected some 20 MB free in this memory file system: remove what lies there, or name another "
    "by RUNTIME_DIRECTORY"
)
MAKE_ROOM = "expected room: delete runs (pa10d run delete), or take another data folder (--data)"


@contextlib.contextmanager
def writing(path: Path) -> Iterator[None]:
    """OSErrors in here name the file, as those of writing do not; numpy's have no number either."""
    try:
        yield
    except OSError as error:
        if error.filename is not None:
            raise
        number = error.errno or errno.ENOSPC
        raise OSError(number, os.strerror(number), str(path)) from error


@contextlib.contextmanager
def sharing(path: Path) -> Iterator[None]:
    """NoRoom where a memory file system takes no more of what processes share there."""
    try:
        with writing(path):
            yield
    except OSError as error:
        raise NoRoom(f"{error.filename}: {error.strerror}; {IN_MEMORY}") from error


def of_the_disk(error: OSError) -> bool:
    """Whether it is the disk's, and no fault of ours."""
    return error.errno in OF_THE_DISK


def disk_words(error: OSError, so: str = "", place: str = "") -> str:
    """One line: where, what, what follows from it, and what to do where it is full. place: in place
    of one that the error does not name; without either it may be no disk of ours."""
    where = error.filename or place
    what = f"{where}: {error.strerror or error}" if where else str(error.strerror or error)
    parts = [what, so, (remedy(error) or "") if where else ""]
    return "; ".join(part for part in parts if part)


def remedy(error: OSError) -> str | None:
    """What to do where a disk is full."""
    return MAKE_ROOM if error.errno in FULL else None
