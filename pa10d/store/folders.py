"""Folders that appear whole or not at all, and who holds a file at the moment."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

NEW, TRASH = ".new-", ".trash-"
_SETTLE = 60.0  # s: younger unfinished folders may belong to a process that is about to lock


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Only one process at a time decides about names and folders in here."""
    with (folder / ".lock").open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def hold(file: Any) -> bool:
    """Mark an open file as being written by this process; False where another one does."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def is_held(path: Path) -> bool:
    """Whether a living process writes the file."""
    try:
        with path.open("rb") as file:
            return not hold(file)
    except FileNotFoundError:
        return False


def write_json(path: Path, document: Any) -> None:
    """Replace the file's content in one step."""
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    write_text(path, text)


def write_text(path: Path, text: str) -> None:
    """Replace the file's content in one step; the old content survives any failure."""
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with fresh.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        fresh.replace(path)
    finally:
        fresh.unlink(missing_ok=True)


def discard(folder: Path) -> None:
    """Delete a folder so that it is gone at once, whatever happens while its files go."""
    trash = folder.with_name(f"{TRASH}{folder.name.lstrip('.')}-{time.time_ns()}")
    folder.rename(trash)
    shutil.rmtree(trash, ignore_errors=True)


def sweep(parent: Path, held_file: str) -> None:
    """Remove what a killed process left: trash, and new folders that nobody writes any more."""
    for folder in parent.glob(f"{TRASH}*"):
        shutil.rmtree(folder, ignore_errors=True)
    for folder in parent.glob(f"{NEW}*"):
        with contextlib.suppress(FileNotFoundError):
            old = time.time() - folder.stat().st_mtime > _SETTLE
            if old and not is_held(folder / held_file):
                shutil.rmtree(folder, ignore_errors=True)
