"""With what right, and on which processor, a thread runs that keeps real time."""

from __future__ import annotations

import contextlib
import os


def take_priority(priority: int) -> list[str]:
    """FIFO for this thread → one sentence where it is refused.

    Threads that it starts later (of the CAN library) keep the usual one.
    """
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except PermissionError:
        return [
            "no real-time priority: cycles may start late; allow it with LimitRTPRIO=90 in the "
            "service or 'rtprio 90' in /etc/security/limits.conf"
        ]
    return []


def stay_on_one() -> None:
    """This thread keeps to the last processor that it is allowed: nothing has to move with it.

    The last, because interrupts go to the first unless told otherwise. The loop and the simulated
    arm that answers it choose the same: waking a second processor takes longer than the answer.
    Another one is chosen from outside, by CPUAffinity= in the service or taskset.
    """
    with contextlib.suppress(OSError):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
