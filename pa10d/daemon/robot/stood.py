"""Where the arm stood when it was at rest and unpowered, for the control process that comes next.

Kept on disk, too, for the daemon that comes next; not of a virtual arm, which begins anew. While
the arm is powered nothing is kept: what ended then left it wherever it came to rest.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import json
import logging
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.disk import disk_words
from pa10d.common.errors import UserError
from pa10d.common.shortage import ready_pool
from pa10d.profile import Profile
from pa10d.store.entries import new_file, read_entry

Array = NDArray[np.float64]

NAME = "stood.json"
MOVED = 1e-3  # rad (m), by which it is written anew
PATIENCE = 2.0  # s for a disk; the arm is powered all the same
STILL = 0.01  # rad/s (m/s)
LARGEST = 1 << 16  # bytes

log = logging.getLogger("pa10d.robot")


class StoodAt:
    """``known``: rad (m), one a joint, or None."""

    def __init__(self, profile: Profile, data: Path) -> None:
        self._drives, self._n = drives_of(profile), len(profile.drives or [])
        self._path = None if profile.simulation is not None else data / NAME
        self._pool = None if self._path is None else ready_pool(1, "stood")  # one after the other
        self._work: asyncio.Future[None] | None = None
        self._said, self._leaving = "", False
        self.known: list[float] | None = self._read()

    def becomes(self, profile: Profile) -> None:
        """The profile is another one now: of other drives or zeros nothing is known."""
        if (now := drives_of(profile)) != self._drives:
            self._drives, self.known = now, None

    def note(self, q: Array, dq: Array) -> None:
        """It stands at q (n,), unpowered, every drive answers."""
        if self._leaving or self._busy or np.abs(dq).max() > STILL:
            return
        if self.known is not None and np.abs(q - np.array(self.known)).max() < MOVED:
            return
        self.known = [float(value) for value in q]
        self._begin(self._write, self.known)

    async def forget(self) -> None:
        """It is about to be powered."""
        self._leaving, self.known = True, None
        try:
            self._begin(self._remove)
            if self._work is not None:
                await asyncio.wait([self._work], timeout=PATIENCE)
        finally:
            self._leaving = False

    def close(self) -> None:
        """What is being written is written to its end."""
        if self._pool is not None:
            self._pool.shutdown(wait=False)

    @property
    def _busy(self) -> bool:
        return self._work is not None and not self._work.done()

    def _begin(self, work: Callable[..., None], *given: Any) -> None:
        if self._pool is not None:
            self._work = asyncio.get_running_loop().run_in_executor(self._pool, work, *given)

    def _read(self) -> list[float] | None:
        """What is damaged, or of other drives, is not known."""
        if self._path is None:
            return None
        with contextlib.suppress(UserError, ValueError, TypeError, KeyError, RecursionError):
            kept = json.loads(read_entry(self._path, LARGEST))
            values = [float(value) for value in kept["stood"]]
            of_these = kept["drives"] == self._drives and len(values) == self._n
            if of_these and all(map(math.isfinite, values)):
                return values
        return None

    def _write(self, stood: list[float]) -> None:
        assert self._path is not None
        draft = self._path.with_name(f".{NAME}")
        try:
            with new_file(draft) as file:
                file.write(json.dumps({"drives": self._drives, "stood": stood}).encode())
            os.replace(draft, self._path)
        except OSError as error:
            self._remove()  # what stands there is no longer true
            self._tell(error, "where the arm stands is not kept")

    def _remove(self) -> None:
        assert self._path is not None
        try:
            self._path.unlink(missing_ok=True)
        except OSError as error:
            self._tell(error, "where the arm stood is kept, though it moves")

    def _tell(self, error: OSError, so: str) -> None:
        words = disk_words(error, so, str(self._path))
        if words != self._said:
            self._said = words
            log.warning("%s", words)


def drives_of(profile: Profile) -> str:
    """What makes angles of a drive's counts: with another one, the same place has another angle."""
    drives = [drive.model_dump(mode="json") for drive in profile.drives or []]
    text = json.dumps([profile.joints, drives], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
