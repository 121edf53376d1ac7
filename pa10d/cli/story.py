"""What the commands that tell a story share: lines on stderr, a seed, a folder for their data."""

from __future__ import annotations

import argparse
import contextlib
import tempfile
import textwrap
import time
from collections.abc import Iterator

from pa10d.cli.answer import note

WIDTH = 92


def tell(words: str) -> None:
    """A line of the story."""
    note(textwrap.fill(words, WIDTH, subsequent_indent="   ", break_long_words=False))


class Slowly:
    """Progress on stderr, a line every few seconds."""

    EVERY = 3.0  # s

    def __init__(self) -> None:
        self._last = time.monotonic()

    def __call__(self, share: float, what: str) -> None:
        now = time.monotonic()
        if now - self._last >= self.EVERY:
            self._last = now
            note(f"   {share:4.0%}  {what}")


@contextlib.contextmanager
def data_folder_or_none(given: str | None) -> Iterator[str]:
    """The folder that was asked for, or one that is gone afterwards."""
    if given is not None:
        yield given
        return
    with tempfile.TemporaryDirectory(prefix="pa10d-") as folder:
        yield folder


def seed(text: str) -> int:
    """Of an option."""
    if not text.isdigit():
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a whole number from 0")
    return int(text)
