"""Messages of processes that must not wait for whoever reads them.

A terminal that was stopped (Ctrl-S), a pager that was not asked to go on, a pipe that nobody reads:
a write waits there for ever, and the loop that holds an arm with it, just as it tells a fault.
"""

from __future__ import annotations

import _thread  # one that `threading` counted would keep computations from forking
import logging
import os
import queue
import select
import sys
import time
import weakref
from contextlib import suppress
from types import TracebackType

MOST = 1000  # messages that wait to be read: what comes then is counted
FAREWELL = 0.3  # s for which a process that ends waits for its last ones
TURN = 0.01  # s
LOST = "… {} more messages that nobody read"


class UnhurriedHandler(logging.Handler):
    """Writes in a thread of its own; ``emit`` returns at once."""

    def __init__(self, descriptor: int = 2) -> None:
        super().__init__()
        self._descriptor = descriptor
        self._begin()
        again = weakref.WeakMethod(self._begin)
        os.register_at_fork(after_in_child=lambda: (begin := again()) and begin())

    def emit(self, record: logging.LogRecord) -> None:
        """Whether it is ever read or not."""
        try:
            self._lines.put_nowait(self.format(record))
        except Exception:  # full, or it cannot be put into words
            self._lost += 1

    def flush(self) -> None:
        """Until all has been written, or for a moment: asked for as a process ends."""
        self.wait()

    def wait(self, seconds: float = FAREWELL) -> None:
        """Until all has been written, or for so long."""
        until = time.monotonic() + seconds
        while self._lines.unfinished_tasks and time.monotonic() < until:
            time.sleep(TURN)

    def _begin(self) -> None:
        """Also in a forked child: it has no thread that writes, and what waits is its parent's."""
        self._lost = 0
        self._lines: queue.Queue[str] = queue.Queue(MOST)
        _thread.start_new_thread(self._write, (self._lines,))

    def _write(self, lines: queue.Queue[str]) -> None:
        while True:
            text = lines.get()
            lost, self._lost = self._lost, 0
            if lost:
                text += "\n" + LOST.format(lost)
            left = (text + "\n").encode(errors="backslashreplace")
            with suppress(OSError):  # it was closed: nobody reads on
                while left:  # past the stream's lock, which others may want
                    left = left[self._written(left) :]
            lines.task_done()

    def _written(self, text: bytes) -> int:
        """How much of it; 0 where whoever shares the terminal has it never wait."""
        try:
            return os.write(self._descriptor, text)
        except BlockingIOError:
            select.select([], [self._descriptor], [])
            return 0


def log_unhurried(form: str, level: int = logging.WARNING) -> None:
    """What this process logs, Python's warnings, and the error that it dies of go to standard error
    that way, in their order."""
    handler = UnhurriedHandler()
    handler.setFormatter(logging.Formatter(form))
    logging.basicConfig(level=level, handlers=[handler])
    logging.captureWarnings(True)
    sys.excepthook = _last_words


def _last_words(kind: type[BaseException], error: BaseException, at: TracebackType | None) -> None:
    if issubclass(kind, Exception):
        logging.critical("ended by an error", exc_info=(kind, error, at))
    else:
        sys.__excepthook__(kind, error, at)
