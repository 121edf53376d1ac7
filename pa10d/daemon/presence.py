"""How a command line finds the daemon that runs on its data: one small file beside them."""

from __future__ import annotations

import contextlib
import json
import logging
import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated

from pydantic import Field, TypeAdapter

from pa10d.common.disk import disk_words, writing
from pa10d.common.errors import UserError
from pa10d.common.locked_file import lock_at_once
from pa10d.store.entries import read_entry

FILE, LARGEST = "daemon.json", 1 << 16  # bytes
LOCK = ".daemon.lock"  # held by whoever serves these data, and by its control process
ADDRESS = r"^http://(\[[0-9A-Fa-f:.%]+\]|[0-9A-Za-z._-]+)(:[0-9]{1,5})?$"

log = logging.getLogger("pa10d")


@dataclass(frozen=True)
class Presence:
    """Where the daemon answers; the token reaches everything and is for this user alone."""

    url: Annotated[str, Field(pattern=ADDRESS)]
    pid: Annotated[int, Field(gt=0, strict=True)]
    profile: str
    token: Annotated[str, Field(pattern=r"^[!-~]([ -~]*[!-~])?$")] | None = None


@contextlib.contextmanager
def announced(data: Path, presence: Presence) -> Iterator[None]:
    """The file exists while the block runs; only its owner may read it."""
    path = data / FILE
    text = json.dumps(vars(presence)).encode()
    try:
        _put(path, text)
    except OSError as error:
        said = "commands beside it do not find this daemon before it is started anew"
        log.warning("%s", disk_words(error, said))
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            path.unlink()


def _put(path: Path, text: bytes) -> None:
    """In one step; on a full disk into the place that the file of an earlier daemon has there."""
    fresh = path.with_name(f".{FILE}.{os.getpid()}")
    try:
        with writing(path):
            fresh.unlink(missing_ok=True)
            _write(fresh, text, os.O_CREAT | os.O_EXCL)
        fresh.replace(path)
    except OSError:
        fresh.unlink(missing_ok=True)
        if not path.is_file():
            raise
        with writing(path):
            _write(path, text, os.O_NOFOLLOW)


def _write(path: Path, text: bytes, how: int) -> None:
    descriptor = os.open(path, os.O_WRONLY | how, 0o600)
    try:
        os.pwrite(descriptor, text, 0)
        os.ftruncate(descriptor, len(text))
    finally:
        os.close(descriptor)


def present(data: Path) -> Presence | None:
    """The daemon on this data. One that was killed leaves its file behind, in which its process may
    be any other by now, and its port that of another arm's daemon; the lock goes with it."""
    try:
        presence = _typed().validate_json(read_entry(data / FILE, LARGEST))
        os.kill(presence.pid, 0)
        return presence if _is_held(data / LOCK) else None
    except (UserError, OSError, ValueError, OverflowError):
        return None


def _is_held(lock: Path) -> bool:
    descriptor = os.open(lock, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        return not lock_at_once(descriptor, shared=True)
    finally:
        os.close(descriptor)


@cache
def _typed() -> TypeAdapter[Presence]:
    return TypeAdapter(Presence)
