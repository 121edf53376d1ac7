"""Drains the ring, and writes the run that the daemon announced before its motion began."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from pa10d.common.errors import UserError
from pa10d.control.ring import Ring
from pa10d.profile import Profile
from pa10d.recorder.session import Ending, Session, channels_of
from pa10d.store import RunInfo, RunStore
from pa10d.store.names import free_name

SILENCE = 1.0  # s without a record, in a run, after which the control process is looked at
HANGS = 10.0  # s without a record from a living one: slow simulators take their time


class Recorder:
    """``announce`` a motion, then call ``drain`` again and again."""

    def __init__(
        self, ring: Ring, store: RunStore, profile: Profile, joints: tuple[str, ...]
    ) -> None:
        self._ring, self._store, self._profile, self._joints = ring, store, profile, joints
        self._session: Session | None = None
        self._next = ring.written
        self._heard = time.monotonic()
        ring.taken = self._next

    @property
    def busy(self) -> bool:
        """Whether a run is being recorded or awaited."""
        return self._session is not None

    @property
    def started(self) -> bool:
        """Whether the announced motion has begun."""
        return self._session is not None and self._session.started

    def announce(
        self,
        motion: int,
        rows: int,
        *,
        name: str | None = None,
        kind: str = "",
        plan_file: str = "",
        tags: tuple[str, ...] = (),
        replace: bool = False,
    ) -> RunInfo:
        """The next motion with this number shall be recorded; without a name it gets one.

        plan_file: what is kept of the plan; it may be larger than a message.
        """
        if self._session is not None:
            raise UserError("a run is being recorded already; wait for its end")
        there = {info.name for info in self._store.all()}
        writer = self._store.start(
            name or free_name(kind or "run", there),
            channels_of(self._joints, self._ring.layout, self._ring.last()),
            self._profile,
            plan=Path(plan_file).read_text(encoding="utf-8") if plan_file else "",
            kind=kind,
            tags=tags,
            replace=replace,
            samples=rows,
        )
        self._session = Session(writer, self._ring.layout, motion, rows)
        self._heard = time.monotonic()
        return writer.info

    def withdraw(self) -> bool:
        """The motion will not come: a run that has not begun goes away. False: it has begun."""
        session = self._session
        if session is None:
            return True
        if session.started:
            return False
        info = session.close(Ending("stopped", "the motion was called off"))
        self._store.delete(info.id)
        self._session = None
        return True

    def drain(self) -> RunInfo | None:
        """Take what is new → the run that ended by it."""
        rows, lost = self._ring.read(self._next)
        self._next += len(rows) + lost
        ended = self._give(rows, lost) if self._session is not None else None
        self._ring.taken = self._next
        return ended

    def leave(self) -> None:
        """Nobody drains the ring from now on."""
        self._ring.taken = -1

    def _silence(self, seconds: float) -> Ending | None:
        """Whether a run without news has ended."""
        if seconds > SILENCE and not is_alive(self._ring.writer):
            return Ending("failed", "the control process ended")
        if seconds > HANGS:
            return Ending("failed", f"no record from the control process for {HANGS:g} s")
        return None

    def _give(self, rows: Any, lost: int) -> RunInfo | None:
        session = self._session
        assert session is not None
        ending = None
        if len(rows):
            self._heard = time.monotonic()
            try:
                ending = session.take(rows, lost)
            except OSError as error:
                self._session = None
                return session.salvage(error)
        elif session.started:
            ending = self._silence(time.monotonic() - self._heard)
        if ending is None:
            return None
        if ending.status in ("aborted", "stopped"):
            ending.reason = str((self._ring.said() or {}).get("sentence", ending.reason))
        self._session = None
        try:
            return session.close(ending)
        except OSError as error:
            return session.salvage(error)


def is_alive(pid: int) -> bool:
    """Whether a process runs (one that has ended and waits to be noticed does not)."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] not in ("Z", "X")
