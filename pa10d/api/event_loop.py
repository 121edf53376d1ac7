"""The event loop of the daemon: whatever it may need of the machine it has from the beginning."""

from __future__ import annotations

import asyncio
import os
import sys

from pa10d.api.crowded_listener import CrowdedListener
from pa10d.common.shortage import ready_pool

BESIDE = 6  # threads for what must not stand in the event loop


def prepare() -> None:
    """The running one. UserError where the machine has no threads left."""
    loop = asyncio.get_running_loop()
    loop.set_exception_handler(CrowdedListener())
    loop.set_default_executor(ready_pool(BESIDE, "beside"))
    _notice_ends_without_threads(loop)


def _notice_ends_without_threads(loop: asyncio.AbstractEventLoop) -> None:
    """Python 3.11 would wait for each process in a thread, which there may be none left for once
    the process runs."""
    if sys.version_info < (3, 12) and hasattr(os, "pidfd_open"):
        watcher = asyncio.PidfdChildWatcher()
        watcher.attach_loop(loop)
        asyncio.set_child_watcher(watcher)
