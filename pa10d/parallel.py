"""A map over several low-priority processes, for computations that come in independent tasks."""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import os
import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

NICENESS = 10
PR_SET_PDEATHSIG = 1
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


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
    kept = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(
        count, mp_context=context, initializer=_begin, initargs=(os.getpid(),)
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


def _begin(parent: int) -> None:
    """Low priority, and gone when the parent is gone, however it ends."""
    os.nice(NICENESS)
    with contextlib.suppress(OSError, AttributeError):  # Linux
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)
