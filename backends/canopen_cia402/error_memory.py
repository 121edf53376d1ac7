"""A drive's own error memory by SDO: 0x1001, 0x603F and 0x1003."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import canopen

from backends.canopen_cia402.remote import Remote, SetupError
from backends.error_history import DriveErrors

REGISTER, ERROR_CODE, HISTORY = 0x1001, 0x603F, 0x1003
MOST = 254  # entries that a history may have

Look = Callable[[Remote], DriveErrors]


def remembered(remote: Remote) -> DriveErrors:
    """What the drive remembers now."""
    count = remote.read(HISTORY)
    history = None
    if count is not None:
        entries = [remote.read(HISTORY, k + 1) for k in range(min(count, MOST))]
        history = tuple(entry for entry in entries if entry is not None)
    return DriveErrors(remote.read(REGISTER), remote.read(ERROR_CODE), history)


def emptied(remote: Remote) -> DriveErrors:
    """The same after its history was emptied, or with why it was not."""
    refused = remote.write(HISTORY, 0)
    left = remembered(remote)
    if refused is None:
        return left
    why = "it keeps no history (0x1003)" if refused == "absent" else f"0x1003: {refused}"
    return DriveErrors(left.register, left.code, left.history, why)


def of_each(nodes: dict[int, canopen.RemoteNode], look: Look) -> list[DriveErrors]:
    """All drives side by side, by axis; call while listening. One that is silent hides no other."""

    def asked(node: canopen.RemoteNode) -> DriveErrors:
        try:
            return look(Remote(node))
        except SetupError as error:
            return DriveErrors(problem=str(error))

    with ThreadPoolExecutor(max(len(nodes), 1)) as pool:
        return list(pool.map(asked, (nodes[axis] for axis in sorted(nodes))))
