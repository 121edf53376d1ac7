"""Priority and memory of the control process, as far as this machine allows; said where not."""

from __future__ import annotations

import ctypes
import gc
import os

PRIORITY = 80
_MCL_CURRENT, _MCL_FUTURE = 1, 2


def prepare(priority: int = PRIORITY) -> list[str]:
    """Freeze garbage collection, take FIFO priority, lock memory → one sentence per refusal.

    A full collection among the objects of a numerical library takes tens of milliseconds.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    return [*take_priority(priority), *_lock_memory()]


def take_priority(priority: int) -> list[str]:
    """FIFO for this thread. Those that it starts later (of the CAN library) keep the usual one."""
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except PermissionError:
        return [
            "no real-time priority: cycles may start late; allow it with LimitRTPRIO=90 in the "
            "service or 'rtprio 90' in /etc/security/limits.conf"
        ]
    return []


def _lock_memory() -> list[str]:
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mlockall(_MCL_CURRENT | _MCL_FUTURE) == 0:
        return []
    return [
        f"memory not locked ({os.strerror(ctypes.get_errno())}): a cycle may wait for the disk; "
        "allow it with LimitMEMLOCK=infinity in the service"
    ]
