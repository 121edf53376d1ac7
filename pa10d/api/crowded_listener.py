"""That no more connections can be taken on is told once in a while, not thousands of times.

asyncio tries on a listening socket as often as clients may wait there, and tells each failure.
"""

from __future__ import annotations

import asyncio
import logging
import os
import time

from pa10d.common.jsonable import JsonObject
from pa10d.common.shortage import OUT_OF

TELL_EVERY = 10.0  # s

log = logging.getLogger("pa10d.api")


class CrowdedListener:
    """A handler of exceptions for an event loop."""

    def __init__(self) -> None:
        self._told_at = -TELL_EVERY

    def __call__(self, loop: asyncio.AbstractEventLoop, context: JsonObject) -> None:
        error = context.get("exception")
        if isinstance(error, OSError) and error.errno in OUT_OF and "socket" in context:
            self._tell(error.errno)
        elif not _of_a_closed_listener(context):
            loop.default_exception_handler(context)

    def _tell(self, number: int) -> None:
        now = time.monotonic()
        if now - self._told_at < TELL_EVERY:
            return
        self._told_at = now
        log.error(
            "no more connections can be taken on: %s; those that are open go on, a signal "
            "(SIGUSR1 to the control process) stops the arm; expected a higher limit (ulimit -n)",
            os.strerror(number),
        )


def _of_a_closed_listener(context: JsonObject) -> bool:
    """Each failure has also asked to be tried again after a second, when the daemon may be gone."""
    again = "_start_serving" in str(context.get("message"))
    return again and isinstance(context.get("exception"), ValueError)
