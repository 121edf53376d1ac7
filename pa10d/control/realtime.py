"""Priority and memory of the control process, as far as this machine allows; said where not."""

from __future__ import annotations

import ctypes
import gc
import os

from pa10d.common.processor import stay_on_one, take_priority

PRIORITY = 80
GATHERED = 10_000  # objects more than were let go since the last look
_MCL_CURRENT, _MCL_FUTURE = 1, 2


def prepare(priority: int = PRIORITY) -> list[str]:
    """Freeze garbage collection, take FIFO priority, stay on one processor, lock memory → one
    sentence per refusal.

    A full collection among the objects of a numerical library takes tens of milliseconds.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    stay_on_one()
    return [*take_priority(priority), *_lock_memory()]


def tidy() -> None:
    """Collect what has gathered since, where no cycle is due. Nobody else does, once ``prepare``
    has switched it off: every try to reach silent drives leaves dictionaries and nodes that hold
    each other, and locked memory besides."""
    if gc.get_count()[0] > GATHERED:
        gc.collect()


def _lock_memory() -> list[str]:
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mlockall(_MCL_CURRENT | _MCL_FUTURE) == 0:
        return []
    return [
        f"memory not locked ({os.strerror(ctypes.get_errno())}): a cycle may wait for the disk; "
        "allow it with LimitMEMLOCK=infinity in the service"
    ]
