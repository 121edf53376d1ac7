"""Progress, one way for all commands: a bar with time left on a terminal, lines elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from pa10d.cli.answer import note

if TYPE_CHECKING:
    from rich.progress import Progress

STEP = 0.1  # share of the whole between two lines that say the same words
SETTLED = 0.05  # share from which on the time left can be told
SHOWN_FROM = 10.0  # s left that are worth a remark in a line
QUIET = 5.0  # s in which nobody at a terminal wonders


def told_if_slow(words: str) -> Callable[[], None]:
    """Says the words at a terminal in a few seconds, unless what is returned was called before."""
    if not sys.stderr.isatty():
        return lambda: None
    waiting = threading.Timer(QUIET, note, [words])
    waiting.daemon = True
    waiting.start()
    return waiting.cancel


class ProgressLine:
    """Called with the share that is done, 0 to 1, and what is being done."""

    def __init__(self) -> None:
        self._began = time.monotonic()
        self._said, self._share, self._most = "", 0.0, 0.0
        self._bar = _bar() if sys.stderr.isatty() else None

    def __call__(self, share: float, words: str) -> None:
        """Shown now; 1 ends it. From one that had settled back to the start: other work begins,
        which has its own time."""
        if share <= SETTLED < self._most:
            self._begin_anew()
        self._most = max(self._most, share)
        if self._bar is not None:
            self._draw(self._bar, share, words)
        elif words not in ("", "done") and (words != self._said or share >= self._share + STEP):
            note(f"{share:4.0%}  {words}{self._left(share)}")
            self._said, self._share = words, share

    def end(self) -> None:
        """Gone from the terminal; also after an error."""
        if self._bar is not None:
            self._bar.stop()

    def _begin_anew(self) -> None:
        self._began, self._most, self._share = time.monotonic(), 0.0, 0.0
        if self._bar is not None and self._bar.live.is_started:
            self._bar.reset(self._bar.task_ids[0])

    def _draw(self, bar: Progress, share: float, words: str) -> None:
        if not bar.live.is_started:
            bar.start()
            bar.add_task(words, total=1.0)
        bar.update(bar.task_ids[0], completed=share, description=words)
        if share >= 1:
            self.end()

    def _left(self, share: float) -> str:
        took = time.monotonic() - self._began
        left = took * (1 - share) / share if share > SETTLED else 0.0
        return f" (about {left:.0f} s left)" if left > SHOWN_FROM else ""


def _bar() -> Progress:
    from rich import progress
    from rich.console import Console

    return progress.Progress(
        progress.BarColumn(30),
        progress.TaskProgressColumn(),
        progress.TimeRemainingColumn(compact=True),
        progress.TextColumn("{task.description}"),
        console=Console(stderr=True),
        transient=True,
    )


_shown: list[ProgressLine] = []


def progress_line() -> ProgressLine:
    """A new one; the command's end ends it."""
    end_progress()
    _shown.append(ProgressLine())
    return _shown[0]


def end_progress() -> None:
    """Whatever is shown is gone, the cursor is back."""
    while _shown:
        _shown.pop().end()


def show_cursor() -> None:
    """Where a bar hid it and nothing else can be waited for."""
    if _shown and sys.stderr.isatty():
        print("\x1b[?25h", end="", file=sys.stderr, flush=True)
