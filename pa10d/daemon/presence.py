"""How a command line finds the daemon that runs on its data: one small file beside them."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pa10d.common.jsonable import JsonObject

FILE = "daemon.json"


@dataclass(frozen=True)
class Presence:
    """Where the daemon answers; the token reaches everything and is for this user alone."""

    url: str
    pid: int
    profile: str
    token: str | None = None


@contextlib.contextmanager
def announced(data: Path, presence: Presence) -> Iterator[None]:
    """The file exists while the block runs; only its owner may read it."""
    path = data / FILE
    fresh = path.with_name(f".{FILE}.{os.getpid()}")
    descriptor = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    with os.fdopen(descriptor, "w") as file:
        json.dump(vars(presence), file)
    fresh.replace(path)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            path.unlink()


def present(data: Path) -> Presence | None:
    """The daemon on this data, if its process is alive."""
    try:
        document: JsonObject = json.loads((data / FILE).read_text())
        presence = Presence(**document)
        os.kill(presence.pid, 0)
    except (OSError, ValueError, TypeError):
        return None
    return presence
