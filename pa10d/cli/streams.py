"""What a command writes to, as it may be found: closed, full, or without our letters."""

from __future__ import annotations

import _thread  # as in ``process``
import codecs
import errno
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import TextIO

MOMENT = 1.0  # s for the last words of a process that is to end


def prepare() -> None:
    """Closed ones lead nowhere (their numbers would be those of the next files to be opened), and a
    letter that they do not have is a question mark, not the end of a command."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        if not _is_open(number):
            os.dup2(os.open(os.devnull, os.O_RDWR), number)
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if not has_all_letters(stream) and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")


def has_all_letters(stream: TextIO) -> bool:
    """Whether what is written to it may be any text."""
    return codecs.lookup(stream.encoding or "ascii").name.startswith("utf")


def give_up(stream: TextIO) -> None:
    """Nobody takes what is written to it: what waits there goes nowhere, without another word."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def for_a_moment(say: Callable[[], object]) -> None:
    """Last words: a terminal or a pipe that nobody reads does not keep a process from ending."""
    said = _thread.allocate_lock()
    said.acquire()

    def saying() -> None:
        with suppress(Exception):  # nor does one that is closed
            say()
        said.release()

    _thread.start_new_thread(saying, ())
    said.acquire(timeout=MOMENT)


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError as error:
        return error.errno != errno.EBADF
    return True
