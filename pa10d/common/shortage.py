"""A machine that gives no more threads, memory, files or processes is told in a line; threads are
there before they are needed."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, BrokenBarrierError

from pa10d.common.errors import NotNow

OUT_OF = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM, errno.EAGAIN)
BEGIN_WITHIN = 10.0  # s for all threads of a pool to have begun


class Short(NotNow):
    """The machine has less than what was asked for takes; nothing was begun."""


def shortage(error: BaseException) -> str | None:
    """What the machine has no more of, where that is what is wrong."""
    what = None
    if isinstance(error, RuntimeError) and str(error) == "can't start new thread":
        what = "no more threads"
    elif isinstance(error, MemoryError):
        what = "no more memory"
    elif isinstance(error, OSError) and error.errno in OUT_OF:
        what = f"no more ({os.strerror(error.errno)})"
    return what and f"this machine gives {what}: end other programs, or raise its limits (ulimit)"


@contextlib.contextmanager
def starting(*ends: socket.socket | int) -> Iterator[None]:
    """A process that cannot be started, or whose end could not be noticed: Short, and the ends of
    its pipe are closed, so that one that runs all the same ends."""
    try:
        yield
    except BaseException as error:
        for end in ends:
            os.close(end) if isinstance(end, int) else end.close()
        if (said := shortage(error)) is not None:
            raise Short(said) from error
        raise


def ready_pool(threads: int, name: str) -> ThreadPoolExecutor:
    """A pool all of whose threads run already: one that begins them as work comes in keeps the work
    that it had no thread for, and does it long after it has said that it cannot."""
    pool = ThreadPoolExecutor(threads, thread_name_prefix=name)
    together = Barrier(threads + 1)
    try:
        for _ in range(threads):
            pool.submit(together.wait)
        together.wait(BEGIN_WITHIN)
    except (RuntimeError, MemoryError, BrokenBarrierError) as error:
        together.abort()
        pool.shutdown(wait=False, cancel_futures=True)
        raise Short(shortage(error) or f"{name}: its threads do not begin") from error
    return pool
