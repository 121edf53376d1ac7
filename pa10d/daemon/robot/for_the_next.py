"""What a daemon keeps of an arm's drives on disk, for the daemon that comes next.

Not of a virtual arm, which begins anew, nor for other drives than these.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import json
import logging
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pa10d.common.disk import disk_words
from pa10d.common.errors import UserError
from pa10d.common.shortage import ready_pool
from pa10d.profile import Profile
from pa10d.store.entries import new_file, read_entry

LARGEST = 1 << 16  # bytes

log = logging.getLogger("pa10d.robot")


class ForTheNext:
    """One value in a file of its own; ``work`` is what is being done to that, in a thread.

    not_kept, not_removed: what it means that the disk does not do so.
    """

    def __init__(
        self, profile: Profile, data: Path, key: str, not_kept: str, not_removed: str
    ) -> None:
        self.drives, self._key = drives_of(profile), key
        self._path = None if profile.simulation is not None else data / f"{key}.json"
        self._pool = None if self._path is None else ready_pool(1, key)  # one after the other
        self._not_kept, self._not_removed, self._said = not_kept, not_removed, ""
        self.work: asyncio.Future[None] | None = None

    def becomes(self, profile: Profile) -> bool:
        """The profile is another one now; whether its drives or their zeros are."""
        before, self.drives = self.drives, drives_of(profile)
        return before != self.drives

    def read(self) -> Any:
        """What is damaged, or of other drives, is None."""
        if self._path is None:
            return None
        with contextlib.suppress(UserError, ValueError, TypeError, KeyError, RecursionError):
            kept = json.loads(read_entry(self._path, LARGEST))
            if kept["drives"] == self.drives:
                return kept[self._key]
        return None

    @property
    def busy(self) -> bool:
        return self.work is not None and not self.work.done()

    def keep(self, value: Sequence[float]) -> None:
        """Written in the background."""
        self._begin(self._write, value)

    def remove(self) -> None:
        """The same of its end."""
        self._begin(self._remove)

    def close(self) -> None:
        """What is being written is written to its end."""
        if self._pool is not None:
            self._pool.shutdown(wait=False)

    def _begin(self, work: Callable[..., None], *given: Any) -> None:
        if self._pool is not None:
            self.work = asyncio.get_running_loop().run_in_executor(self._pool, work, *given)

    def _write(self, value: Sequence[float]) -> None:
        assert self._path is not None
        draft = self._path.with_name(f".{self._path.name}")
        try:
            with new_file(draft) as file:
                file.write(json.dumps({"drives": self.drives, self._key: value}).encode())
            os.replace(draft, self._path)
        except OSError as error:
            self._remove()  # what stands there is no longer true
            self._tell(error, self._not_kept)

    def _remove(self) -> None:
        assert self._path is not None
        try:
            self._path.unlink(missing_ok=True)
        except OSError as error:
            self._tell(error, self._not_removed)

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
