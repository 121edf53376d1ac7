"""Messages of processes that must not wait for whoever reads them.

A terminal that was stopped (Ctrl-S), a pager that was not asked to go on, a pipe that nobody reads:
a write waits there for ever, and the loop that holds an arm with it, just as it tells a fault.
"""

from __future__ import annotations

import atexit
import logging
import os
import queue
import threading
import time
from contextlib import suppress

MOST = 1000  # messages that wait to be read: what comes then is counted
FAREWELL = 0.3  # s for which a process that ends waits for its last ones
TURN = 0.01  # s
LOST = "… {} more messages that nobody read"


class UnhurriedHandler(logging.Handler):
    """Writes in a thread of its own; ``emit`` returns at once."""

    def __init__(self, descriptor: int = 2) -> None:
        super().__init__()
        self._descriptor, self._lost = descriptor, 0
        self._lines: queue.Queue[str] = queue.Queue(MOST)
        threading.Thread(target=self._write, name="messages", daemon=True).start()
        atexit.register(self.wait)

    def emit(self, record: logging.LogRecord) -> None:
        """Whether it is ever read or not."""
        try:
            self._lines.put_nowait(self.format(record))
        except Exception:  # full, or it cannot be put into words
            self._lost += 1

    def wait(self, seconds: float = FAREWELL) -> None:
        """Until all has been written, or for so long."""
        until = time.monotonic() + seconds
        while self._lines.unfinished_tasks and time.monotonic() < until:
            time.sleep(TURN)

    def _write(self) -> None:
        while True:
            text = self._lines.get()
            lost, self._lost = self._lost, 0
            if lost:
                text += "\n" + LOST.format(lost)
            left = (text + "\n").encode(errors="backslashreplace")
            with suppress(OSError):  # it was closed: nobody reads on
                while left:  # past the stream's lock, which others may want
                    left = left[os.write(self._descriptor, left) :]
            self._lines.task_done()


def log_unhurried(form: str, level: int = logging.WARNING) -> None:
    """What this process logs, and Python's warnings, go to standard error that way."""
    handler = UnhurriedHandler()
    handler.setFormatter(logging.Formatter(form))
    logging.basicConfig(level=level, handlers=[handler])
    logging.captureWarnings(True)
