"""Folders that appear whole or not at all, and who holds a file at the moment."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pa10d.common.disk import writing
from pa10d.common.errors import Busy, UserError
from pa10d.common.locked_file import lock_at_once
from pa10d.store.entries import new_file, own_folder

NEW, TRASH = ".new-", ".trash-"
PATIENCE = 5.0  # s for which the lock is waited for; it is held for milliseconds as a rule
_LOOK_AGAIN = 0.01  # s
_DISCARDED = re.compile(rf"{re.escape(TRASH)}.+-[0-9]{{9,}}")  # as ``discard`` names them
_BEGUN = re.compile(rf"{re.escape(NEW)}[0-9]{{8}}-[0-9]{{6}}")  # with an id of ours
_SETTLE = 60.0  # s: younger unfinished folders may belong to a process that is about to lock


@contextlib.contextmanager
def locked(folder: Path, patience: float | None = None) -> Iterator[None]:
    """Only one process at a time decides about names and folders in here.

    Busy where the other one does not let go within ``patience`` seconds: it may stand still.
    """
    path = folder / ".lock"
    try:
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}; expected a file that can be locked") from error
    try:
        until = time.monotonic() + (PATIENCE if patience is None else patience)
        while not lock_at_once(file):
            if time.monotonic() > until:
                raise Busy(f"{folder}: {_holder(file)} has held it for too long; try again")
            time.sleep(_LOOK_AGAIN)
        with contextlib.suppress(OSError):  # a full disk keeps nobody from the lock
            os.ftruncate(file, 0)
            os.pwrite(file, str(os.getpid()).encode(), 0)
        yield
    finally:
        os.close(file)


def _holder(file: int) -> str:
    said = os.pread(file, 20, 0).decode("ascii", "replace")
    return f"process {said}" if said.isdecimal() else "another process"


def is_held(path: Path) -> bool:
    """Whether a living process writes the file."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return False
    with os.fdopen(descriptor, "rb") as file:
        return not lock_at_once(file)


def write_json(path: Path, document: Any) -> None:
    """Replace the file's content in one step."""
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    write_text(path, text)


def write_text(path: Path, text: str) -> None:
    """Replace the file's content in one step; the old content survives any failure."""
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with writing(path), new_file(fresh) as file:
            file.write(text.encode())
            file.flush()
            os.fsync(file.fileno())
        fresh.replace(path)
    finally:
        fresh.unlink(missing_ok=True)


def write_into(entry: Path, name: str, text: str) -> None:
    """A file of an entry, in one step; a folder that there was none of comes with it or not."""
    own_folder(entry)
    try:
        write_text(entry / name, text)
    except BaseException:
        with contextlib.suppress(OSError):
            entry.rmdir()  # only where nothing is in it
        raise


def discard(folder: Path) -> None:
    """Delete a folder so that it is gone at once, whatever happens while its files go."""
    trash = folder.with_name(f"{TRASH}{folder.name.lstrip('.')}-{time.time_ns()}")
    folder.rename(trash)
    shutil.rmtree(trash, ignore_errors=True)


def sweep(parent: Path, held_file: str) -> None:
    """Remove what a killed process left: trash, and new folders that nobody writes any more. No
    others whose names only begin so: ``parent`` may be a link to where somebody keeps more."""
    for folder in parent.glob(f"{TRASH}*"):
        if _DISCARDED.fullmatch(folder.name):
            shutil.rmtree(folder, ignore_errors=True)
    for folder in parent.glob(f"{NEW}*"):
        if not _BEGUN.match(folder.name):
            continue
        with contextlib.suppress(OSError):
            old = time.time() - folder.lstat().st_mtime > _SETTLE
            if old and not is_held(folder / held_file):
                shutil.rmtree(folder, ignore_errors=True)
