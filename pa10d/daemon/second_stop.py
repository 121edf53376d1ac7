"""A stop that does not need the daemon to answer: its control process obeys a signal."""

from __future__ import annotations

import contextlib
import os
import signal
from pathlib import Path

CONTROL = [b"-m", b"pa10d.control"]


def stop_by_signal(daemon: int) -> bool:
    """The control process of this daemon (pid) brings the arm to rest along its limits and holds
    it. False where there is none. To any other process the signal may be the end: whose child it
    is counts, and what it was started as."""
    told = False
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError, ValueError, IndexError):
            words = (process / "cmdline").read_bytes().split(b"\0")
            if CONTROL not in (words[k : k + 2] for k in range(len(words))):
                continue
            after_its_name = (process / "stat").read_text().rpartition(")")[2].split()
            if int(after_its_name[1]) == daemon:
                os.kill(int(process.name), signal.SIGUSR1)
                told = True
    return told
