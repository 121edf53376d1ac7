"""How many threads and processes a computation takes.

Maps over several processes are for what comes in independent tasks: fresh ones at low priority for
tasks that say all they need, a forked one for tasks that share much in memory. One thread of linear
algebra is for matrices that are many and small.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import pickle
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import cache
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, NoReturn, TypeVar

from threadpoolctl import ThreadpoolController

T = TypeVar("T")
R = TypeVar("R")

NICENESS = 10
PR_SET_PDEATHSIG = 1
WARNINGS = "PYTHONWARNINGS"  # of who clears up behind a command that was ended at once
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def one_thread() -> Iterator[None]:
    """Linear algebra on one thread (``with`` or decorator): where matrices are many and small the
    others would mostly wait."""
    with _linear_algebra().limit(limits=1):
        yield


@cache
def _linear_algebra() -> ThreadpoolController:
    """The libraries that have threads of their own; looking for them takes a millisecond."""
    return ThreadpoolController().select(user_api="blas")


@contextmanager
def process_map(workers: int | None = None) -> Iterator[Any]:
    """A ``map`` that keeps order; ``workers``: processes, default one per processor.

    One worker or one processor means the built-in map. The processes are fresh (spawned): threads
    and locks of the caller are not theirs, and linear algebra runs on one thread in each.
    """
    count = workers if workers is not None else len(os.sched_getaffinity(0))
    if count <= 1:
        yield map
        return
    kept = {name: os.environ.get(name) for name in (*ONE_THREAD, WARNINGS)}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    os.environ[WARNINGS] = ",".join(filter(None, (kept[WARNINGS], "ignore:resource_tracker")))
    pool = ProcessPoolExecutor(
        count, mp_context=_Context(), initializer=_begin, initargs=(os.getpid(),)
    )
    try:
        yield pool.map
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        for name, value in kept.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


class _Deaf(SpawnProcess):
    """Never hears Ctrl-C, not even while it starts: a terminal sends it to all of its processes,
    and it is the command's own to end the others."""

    def start(self) -> None:
        """With the signal held back, which processes inherit."""
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Context(SpawnContext):
    Process = _Deaf


def _begin(parent: int) -> None:
    """Low priority, and gone when the parent is gone, however it ends."""
    os.nice(NICENESS)
    _end_with_parent()
    if os.getppid() != parent:
        os._exit(1)


def _end_with_parent() -> None:
    with contextlib.suppress(OSError, AttributeError):  # Linux
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def shared_map(
    function: Callable[[T], R],
    items: Sequence[T],
    tick: Callable[[float], None] = lambda share: None,
) -> list[R]:
    """``[function(item) for item in items]``; where there is a second processor, every other item
    is done by a forked child, which sees all that is in memory and sends back its results.

    Threads do not survive a fork and the locks that they hold do, so a process that has any does
    everything itself, as it does what a child left undone. tick: share done, by this process.
    """
    alone = threading.active_count() > 1 or len(os.sched_getaffinity(0)) < 2 or len(items) < 2
    if alone:
        return _done(function, items, tick)
    source, sink = os.pipe()
    child = os.fork()
    if child == 0:
        _as_child(function, items[1::2], sink)
    os.close(sink)
    try:
        with os.fdopen(source, "rb") as answers:
            mine = _done(function, items[::2], tick)
            told = answers.read()
    except BaseException:
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        os.waitpid(child, 0)
    others = pickle.loads(told) if told else _done(function, items[1::2])
    if isinstance(others, Exception):
        raise others
    out: list[R] = [*mine, *others]
    out[::2], out[1::2] = mine, others
    return out


def _done(
    function: Callable[[T], R],
    items: Sequence[T],
    tick: Callable[[float], None] = lambda share: None,
) -> list[R]:
    out = []
    for number, item in enumerate(items, 1):
        out.append(function(item))
        tick(number / len(items))
    return out


def _as_child(function: Callable[[T], R], items: Sequence[T], sink: int) -> NoReturn:
    """Compute, tell, and end without any of the parent's farewells."""
    try:
        _end_with_parent()
        try:
            told: Any = _done(function, items)
        except Exception as error:
            told = error
        with os.fdopen(sink, "wb") as answers:
            pickle.dump(told, answers, pickle.HIGHEST_PROTOCOL)
        logging.shutdown()  # what it has to say waits in the process, as its parent's
    finally:
        os._exit(0)
