"""One virtual arm on a bus: a lock that goes with the process that plays it."""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.common.locked_file import lock_at_once, still_there
from pa10d.profile import Profile

LOOKED_AT = 0.5  # s; whoever only looks whether there is an arm holds it for an instant
LEAVES, OWNED = b"leaves", b"daemon"  # the second is followed by the daemon's process
SAID = 32  # bytes at most


class Held:
    """What the virtual arm has."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def leave(self) -> None:
        """Say that this arm is about to end: nobody is to begin anything with it."""
        os.pwrite(self._descriptor, LEAVES, 0)


def lock_path(profile: Profile) -> Path:
    """Held by the virtual arm of this bus."""
    name = f"pa10d-sim-{os.getuid()}-{profile.can.interface}-{profile.can.channel}.lock"
    return Path(tempfile.gettempdir()) / name.replace(os.sep, "_")


def is_simulated(profile: Profile) -> bool:
    """Whether a virtual arm is on this bus, one that leaves included."""
    return _said(profile) is not None


def arm_leaves(profile: Profile) -> bool:
    """Whether the virtual arm of this bus is about to end: its daemon has gone."""
    return (_said(profile) or b"").startswith(LEAVES)


def refuse_arm_of_others(profile: Profile, daemon: int | None = None) -> None:
    """UserError where the virtual arm of this bus is another daemon's than the one of this process
    id: it obeys that one, and hides what that one was asked to hide."""
    said = _said(profile) or b""
    number = said.removeprefix(OWNED).strip()
    if not said.startswith(OWNED) or not number.isdigit():
        return
    owner = int(number)
    if owner != daemon and Path(f"/proc/{owner}").exists():
        raise UserError(
            f"the virtual arm on '{profile.can.channel}' is of another daemon, process {owner}; "
            "expected that one to be used or ended, or --channel NAME for an arm of its own"
        )


def _said(profile: Profile) -> bytes | None:
    """By the arm that is there; None: there is none."""
    try:
        descriptor = os.open(lock_path(profile), os.O_RDONLY | os.O_CLOEXEC)
    except FileNotFoundError:
        return None
    try:
        there = not lock_at_once(descriptor, shared=True)
        return os.pread(descriptor, SAID, 0) if there else None
    finally:
        os.close(descriptor)


@contextlib.contextmanager
def arm_lock(profile: Profile, daemon: int | None = None) -> Iterator[Held | None]:
    """Be the virtual arm of this bus for the length of the block; None: there is one. daemon: the
    process that it is played for alone."""
    path, until = lock_path(profile), time.monotonic() + LOOKED_AT
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        if lock_at_once(descriptor):
            if still_there(path, descriptor):
                break
        elif time.monotonic() > until:
            os.close(descriptor)
            yield None
            return
        os.close(descriptor)
        time.sleep(0.01)
    os.ftruncate(descriptor, 0)
    if daemon is not None:
        os.pwrite(descriptor, OWNED + f" {daemon}".encode(), 0)
    try:
        yield Held(descriptor)
    finally:
        path.unlink(missing_ok=True)
        os.close(descriptor)


@contextlib.contextmanager
def only_arm(profile: Profile) -> Iterator[None]:
    """The same for whoever was started by hand: UserError where there is one. Two would answer
    with the same node ids."""
    with arm_lock(profile) as held:
        if held is None:
            raise UserError(f"a virtual arm is on '{profile.can.channel}' already")
        yield
