"""Runs that somebody waits for until the recorder has closed them."""

from __future__ import annotations

import asyncio

from pa10d.daemon.processes.link import Message


class AwaitedRuns:
    """By id; each ends with the run's description, or with why there will be none."""

    def __init__(self) -> None:
        self._each: dict[str, asyncio.Future[Message]] = {}

    def expect(self, run: str) -> asyncio.Future[Message]:
        """The description of this run once the recorder has closed it."""
        self._each[run] = asyncio.get_running_loop().create_future()
        return self._each[run]

    def forget(self, run: str) -> None:
        """Nobody waits for it any more."""
        future = self._each.pop(run, None)
        if future is not None and future.done() and not future.cancelled():
            future.exception()  # seen

    def closed(self, info: Message) -> None:
        """The recorder has closed a run."""
        future = self._each.get(info["id"])
        if future is not None and not future.done():
            future.set_result(info)

    def lost(self, why: Exception) -> None:
        """The recorder is gone, and with it what was not closed."""
        for future in self._each.values():
            if not future.done():
                future.set_exception(why)
