"""Files that are sent to the daemon: each into a folder of its own within the data folder."""

from __future__ import annotations

import asyncio
import contextlib
import shutil
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

from fastapi import Request

from pa10d.api.problems import Problem
from pa10d.common.errors import UserError
from pa10d.daemon.daemon import Daemon
from pa10d.store.entries import own_folder, refuse_links

FOLDER = "uploads"  # within the data folder
PIECE = 1 << 20  # bytes that are written in one go
BODY = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}


@contextlib.asynccontextmanager
async def place_for(daemon: Daemon) -> AsyncIterator[str]:
    """A folder of one's own for the time of a request."""
    place = await new_place(daemon)
    try:
        yield place.name
    finally:
        await asyncio.to_thread(place.cleanup)


async def new_place(daemon: Daemon) -> tempfile.TemporaryDirectory[str]:
    """A folder of one's own until it is cleaned up."""
    return await daemon.shelf(_make_place, daemon.data / FOLDER)


def clear(data: Path) -> None:
    """Nothing is left of what was sent to a daemon that was killed."""
    with contextlib.suppress(UserError):
        refuse_links(data / FOLDER, "folder")
        _empty(data / FOLDER)


def _empty(folder: Path) -> None:
    for place in folder.glob("*"):
        shutil.rmtree(place, ignore_errors=True)


async def take(request: Request, path: Path, daemon: Daemon) -> None:
    """The body into a file, a piece at a time."""
    with await daemon.shelf(path.open, "wb") as file:
        waiting = bytearray()
        async for part in request.stream():
            waiting += part
            if len(waiting) >= PIECE:
                await daemon.shelf(file.write, bytes(waiting))
                waiting.clear()
        await daemon.shelf(file.write, bytes(waiting))
        await daemon.shelf(file.flush)


def plain_name(filename: str) -> str:
    """The last part of a file name: it names the run, and a file in a folder of its own."""
    plain = filename.replace("\\", "/").rpartition("/")[2]
    if plain.strip(". ") == "" or any(ord(c) < 32 for c in plain):
        raise Problem("refused", f"file name {filename!r}: expected a plain name")
    return plain


def _make_place(folder: Path) -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(dir=own_folder(folder), ignore_cleanup_errors=True)
