"""The process around a command: Ctrl-C acts within a second, whatever is being computed.

Python notices an interrupt between two of its own steps only. A thread that does nothing else
gives the command a moment to end by itself, then ends the process: what is stored appears whole or
not at all, and processes that were started end with the one that started them.
"""

from __future__ import annotations

import _thread  # one that `threading` counted would keep computations from forking
import atexit
import os
import signal
import sys
import time
from contextlib import suppress
from functools import partial
from typing import NoReturn

from pa10d.cli import INTERRUPTED, main, streams
from pa10d.cli.answer import note
from pa10d.cli.commands import current
from pa10d.cli.progress import show_cursor

GRACE = 0.7  # s
TURN = 0.05  # s
WAITS = "interrupted: what was started is being ended (once more: leave at once)"
TURNS = 40  # after which the thread that watches has had one, however busy the machine


def run() -> NoReturn:
    """The command that the process was started for, and its status."""
    streams.prepare()
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    interrupted: list[float] = []
    repeated: list[float] = []
    _thread.start_new_thread(_watch, (reading, interrupted, repeated))
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.unraisablehook = partial(_unraisable, repeated)
    # Python takes its handlers back as it ends; the first that is registered is the last that runs
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
    try:
        status = main()
    except BaseException as error:
        if not isinstance(error, KeyboardInterrupt) and not _seen(interrupted):
            raise
        status = INTERRUPTED  # libraries make other errors of an interrupt
    if interrupted or status == INTERRUPTED:
        _leave()
    _done(status)


def _done(status: int) -> NoReturn:
    """What was asked for is done and told: an interrupt from here on changes its status no more."""

    def at_once(*_: object) -> None:
        for stream in (sys.stdout, sys.stderr):
            with suppress(Exception):  # it may be closed by now, or be flushed just then
                stream.flush()
        os._exit(status)

    signal.signal(signal.SIGINT, at_once)
    sys.exit(status)


def _unraisable(repeated: list[float], what: sys.UnraisableHookArgs) -> None:
    """An interrupt that fell into a callback of Python's went no further: it comes once more."""

    main_thread = _thread.get_ident()  # Python takes signals there alone

    def again() -> None:
        time.sleep(TURN)
        repeated.append(time.monotonic())
        signal.pthread_kill(main_thread, signal.SIGINT)  # ends what it waits for, too

    if isinstance(what.exc_value, KeyboardInterrupt):
        _thread.start_new_thread(again, ())
    else:
        sys.__unraisablehook__(what)


def _seen(interrupted: list[float]) -> bool:
    """Whether there was an interrupt; the thread that notes it may not have had its turn yet."""
    for _ in range(TURNS):
        if interrupted:
            return True
        time.sleep(TURN)
    return False


def _watch(reading: int, interrupted: list[float], repeated: list[float]) -> None:
    while signals := os.read(reading, 64):
        if signal.SIGINT not in signals:
            continue
        if repeated:
            repeated.pop()
            continue
        again = bool(interrupted)
        interrupted.append(time.monotonic())
        time.sleep(GRACE)
        if again or not current.patient:
            streams.for_a_moment(partial(note, "interrupted"))
            _leave()
        streams.for_a_moment(partial(note, WAITS))


def _leave() -> NoReturn:
    """Without farewells: threads and processes that compute are not waited for."""
    if "multiprocessing" in sys.modules:
        import multiprocessing

        for child in multiprocessing.active_children():
            child.kill()
    streams.for_a_moment(_farewell)
    os._exit(INTERRUPTED)


def _farewell() -> None:
    show_cursor()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
