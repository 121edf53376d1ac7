"""Files that are locked by whoever has them open, however that ends."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path
from typing import IO, Any


def lock_at_once(file: int | IO[Any], shared: bool = False) -> bool:
    """Whether the lock of this open file, or descriptor, is ours now; without waiting."""
    try:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def still_there(path: Path, descriptor: int) -> bool:
    """Whether the name still means the file that is open: while we waited for its lock, the last
    holder may have deleted it."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(descriptor))
    except FileNotFoundError:
        return False
