"""File work beside the event loop, which must never wait for a disk or for somebody's lock."""

from __future__ import annotations

import asyncio
import contextvars
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

from pa10d.common.shortage import ready_pool
from pa10d.daemon.processes.crowded import Crowded

THREADS = 4
MOST = 256  # pieces of work that are waited for at a time

Result = TypeVar("Result")


class Shelf:
    """``await shelf(function, …)``: what it returns or raises, from a thread of its own pool.

    The threads of others (static files, downloads) are never taken: these here may all stand still
    behind one lock.
    """

    def __init__(self, name: str) -> None:
        self._pool = ready_pool(THREADS, name)
        self._waiting = 0

    async def __call__(self, work: Callable[..., Result], *args: Any, **more: Any) -> Result:
        """Crowded where too many wait already."""
        if self._waiting >= MOST:
            raise Crowded(f"{self._waiting} requests wait for the data folder; try again")
        self._waiting += 1
        try:
            call = partial(contextvars.copy_context().run, partial(work, *args, **more))
            return await asyncio.get_running_loop().run_in_executor(self._pool, call)
        finally:
            self._waiting -= 1

    def close(self) -> None:
        """What has not begun never will."""
        self._pool.shutdown(wait=False, cancel_futures=True)
