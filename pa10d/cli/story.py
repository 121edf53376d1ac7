"""What the commands that tell a story share: lines on stderr, a seed, a folder for their data."""

from __future__ import annotations

import argparse
import contextlib
import signal
import tempfile
import textwrap
from collections.abc import Iterator
from pathlib import Path

from pa10d.cli.answer import note

WIDTH = 92


def tell(words: str) -> None:
    """A line of the story."""
    note(textwrap.fill(words, WIDTH, subsequent_indent="   ", break_long_words=False))


def end_as_after_interrupt() -> None:
    """SIGTERM ends a story as Ctrl-C does: with every process that it started."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)


@contextlib.contextmanager
def study_folder(given: str | None) -> Iterator[Path]:
    """The folder that was asked for, or one that is gone afterwards."""
    if given is not None:
        yield Path(given)
        return
    with tempfile.TemporaryDirectory(prefix="pa10d-") as folder:
        yield Path(folder)


def seed_number(text: str) -> int:
    """Of an option."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a whole number from 0")
    return int(text)
