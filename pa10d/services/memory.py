"""Whether recordings fit into memory with what is to be done with them: said before it begins."""

from __future__ import annotations

import contextlib
import resource
from collections.abc import Iterable, Sequence
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.store import RunInfo

NEEDED = {"compare": 130, "diagnose": 400}
"""Bytes per sample and joint at the peak, as measured (decision 0191); a fit has no such limit."""
PLANNED = 100  # bytes per row and joint of a motion that is planned and checked, measured: 90
BASE = 350_000_000  # bytes of a command that looks at next to nothing
SMALL = 2_000_000_000  # bytes that are let go on without a look at what is free
_CGROUP = Path("/sys/fs/cgroup")
_KIB = 1024


def refuse_beyond_memory(what: str, infos: Sequence[RunInfo]) -> None:
    """UserError, before anything is read, where ``what`` would need more memory than is free."""
    runs = {info.id: info for info in infos}.values()
    values = sum(info.samples * len(info.joints) for info in runs)
    needed = BASE + NEEDED[what] * values
    there = free_memory()
    if needed <= max(there, SMALL):
        return
    minutes = sum(info.duration for info in runs) / 60
    fit = minutes * max(0.0, there - BASE) / (needed - BASE)
    raise UserError(
        f"{what}: {minutes:.0f} min of recordings ({values / 1e6:.0f} million values) need about "
        f"{needed / 1e9:.1f} GB of memory, {there / 1e9:.1f} GB are free; expected fewer or "
        f"shorter ones, {_rounded(fit)} of such recordings in all"
    )


def refuse_endless_motion(kind: str, seconds: float, rate: float, joints: int) -> None:
    """UserError where the rows of a motion would need more memory than is free."""
    needed = BASE + PLANNED * seconds * rate * joints
    there = free_memory()
    if needed <= there:
        return
    hours, fit = seconds / 3600, max(0.0, there - BASE) / (PLANNED * rate * joints) / 3600
    raise UserError(
        f"{kind}: a motion of {hours:.3g} h needs about {needed / 1e9:.3g} GB of memory, "
        f"{there / 1e9:.1f} GB are free; expected at most {fit:.1g} h"
    )


def free_memory() -> int:
    """Bytes that this process may still take: of the machine, of its group, of its own limit."""
    return min(_free())


def _free() -> Iterable[int]:
    yield from _stated("/proc/meminfo", "MemAvailable")
    with contextlib.suppress(OSError, ValueError):
        most = int((_CGROUP / "memory.max").read_text())
        yield most - int((_CGROUP / "memory.current").read_text())
    limit = resource.getrlimit(resource.RLIMIT_DATA)[0]
    if limit != resource.RLIM_INFINITY:
        yield limit - sum(_stated("/proc/self/status", "VmData"))
    yield 1 << 62


def _stated(file: str, name: str) -> Iterable[int]:
    """A line ``Name:  123 kB`` of the kernel, in bytes."""
    with contextlib.suppress(OSError, ValueError):
        for line in Path(file).read_text().splitlines():
            if line.startswith(f"{name}:"):
                yield int(line.split()[1]) * _KIB


def _rounded(minutes: float) -> str:
    return f"{minutes:.0f} min" if minutes >= 10 else f"{minutes:.1g} min"
