"""What one job may take of the machine: memory and time. The arm comes before any analysis."""

from __future__ import annotations

import contextlib
import os
from dataclasses import dataclass
from pathlib import Path

SMALLEST, LARGEST = 1 << 30, 8 << 30  # bytes of memory
_CGROUP = Path("/sys/fs/cgroup/memory.max")


@dataclass(frozen=True)
class Budget:
    """memory: bytes of one process; seconds: until it is ended."""

    memory: int
    seconds: float

    def time_is_over(self) -> str:
        """What is said then."""
        return f"ended after {self.seconds:g} s, which is all that one such job may take"


def memory_of_machine() -> int:
    """Bytes of memory that this process could get at most."""
    physical = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    with contextlib.suppress(OSError, ValueError):
        return min(physical, int(_CGROUP.read_text()))
    return physical


def share_of_memory() -> int:
    """Half of the machine's memory, within reason; PA10D_JOB_MEMORY (MiB) says otherwise."""
    given = os.environ.get("PA10D_JOB_MEMORY", "")
    if given.isascii() and given.isdigit():
        return max(1, int(given)) << 20
    return min(max(memory_of_machine() // 2, SMALLEST), LARGEST)


def of_a_job() -> Budget:
    """For identification, diagnosis, optimisation."""
    return Budget(share_of_memory(), 3600.0)


def of_an_answer() -> Budget:
    """For what a request waits for."""
    return Budget(share_of_memory(), 120.0)
