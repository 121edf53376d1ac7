"""One master on a bus: a lock among the processes of this machine.

A lock of the kernel on an open file: it goes with the process, however that ends.
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from pathlib import Path
from urllib.parse import quote

from backends.faults import fault
from pa10d.common.errors import UserError
from pa10d.common.locked_file import lock_at_once, still_there
from pa10d.profile import Can

FOLDERS = (Path("/run/lock"), Path("/var/lock"))  # for all users; then what is our own


class BusLock:
    """Held from ``take`` to ``release``."""

    def __init__(self, settings: Can) -> None:
        self._settings = settings
        self._descriptor: int | None = None
        self._path = Path()

    def take(self) -> None:
        """BackendFault ``bus_taken`` where another process, or another backend of ours, has it."""
        if self._descriptor is not None:
            return
        while True:
            path, descriptor = _open(lock_name(self._settings))
            if not lock_at_once(descriptor):
                holder = os.pread(descriptor, 200, 0).decode(errors="replace").strip()
                os.close(descriptor)
                bus = f"{self._settings.interface} {self._settings.channel}"
                by = f" by {holder}" if holder else ""
                raise fault("bus_taken", f"the bus {bus} is held{by}: drives obey one master only")
            if still_there(path, descriptor):
                break
            os.close(descriptor)  # its last holder deleted it before we had it
        with contextlib.suppress(OSError):  # for the message only; another user's file is as good
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, _who_we_are().encode(), 0)
        self._path, self._descriptor = path, descriptor

    def release(self) -> None:
        """Deleted while it is held; whoever waits with the old file open looks again."""
        if self._descriptor is not None:
            with contextlib.suppress(OSError):  # another user's file stays
                self._path.unlink()
            os.close(self._descriptor)
            self._descriptor = None


def lock_name(settings: Can) -> str:
    """One name for one bus; a device's other names in /dev are the same one."""
    channel = settings.channel
    if os.path.isabs(channel):
        channel = os.path.realpath(channel)
    return f"pa10d-bus-{quote(settings.interface, safe='')}@{quote(channel, safe='')}.lock"


def _open(name: str) -> tuple[Path, int]:
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    for folder in (*FOLDERS, *([Path(runtime)] if runtime else []), Path(tempfile.gettempdir())):
        with contextlib.suppress(OSError):
            return folder / name, _open_in(folder / name)
    raise UserError(f"{name}: nowhere to lock the bus; expected one writable folder of {FOLDERS}")


def _open_in(path: Path) -> int:
    """Not made where it exists: in folders for all, the kernel refuses that on others' files."""
    flags = os.O_CLOEXEC | os.O_NOFOLLOW
    for _ in range(3):
        for mode in (os.O_RDWR, os.O_RDONLY):
            with contextlib.suppress(FileNotFoundError, PermissionError):
                return os.open(path, flags | mode)
        with contextlib.suppress(FileExistsError):
            descriptor = os.open(path, flags | os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
            os.fchmod(descriptor, 0o666)  # whatever the umask: another user shall see it held
            return descriptor
    raise PermissionError(path)


def _who_we_are() -> str:
    command = " ".join(Path(part).name for part in sys.orig_argv[:6])
    return f"process {os.getpid()} ({command})"
