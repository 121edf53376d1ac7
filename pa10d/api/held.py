"""Files that were sent and wait for a decision: looked at, corrected, imported or let go."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import tempfile
import time
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field
from pathlib import Path

from pa10d.api.problems import Problem

MOST = 8  # files at a time: the oldest goes first
LONGEST = 3600.0  # s that one is kept
LOOK_EVERY = 60.0  # s between looks at their age


@dataclass
class HeldFile:
    """path: in a folder of its own, which goes with it."""

    place: tempfile.TemporaryDirectory[str]
    path: Path
    id: str = field(default_factory=lambda: secrets.token_hex(8))
    since: float = 0.0

    async def clear(self) -> None:
        """Nothing of it is left on disk."""
        await asyncio.to_thread(self.place.cleanup)


class HeldFiles:
    """What one daemon's visitors are deciding about."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._files: dict[str, HeldFile] = {}
        self._taken: set[str] = set()
        self._clock = clock

    async def keep(self, held: HeldFile) -> None:
        """From now on it is known by its id; old ones go."""
        held.since = self._clock()
        self._files[held.id] = held
        await self.tidy()

    def get(self, number: str) -> HeldFile:
        """Problem where there is none, or no longer, or not now."""
        if number in self._taken:
            raise Problem("conflict", f"file {number!r} is being imported or let go just now")
        if number not in self._files:
            raise Problem("not-found", f"no file {number!r} is waiting; send it again")
        return self._files[number]

    @contextlib.asynccontextmanager
    async def taken(self, number: str) -> AsyncIterator[HeldFile]:
        """It, out of everybody's reach while it is decided about; gone then, or, where that failed,
        waiting as before."""
        held = self._files.pop(self.get(number).id)
        self._taken.add(held.id)
        try:
            yield held
            await held.clear()
        except BaseException:
            if held.path.exists():
                self._files[held.id] = held
            raise
        finally:
            self._taken.discard(held.id)

    async def let_go(self, number: str) -> HeldFile:
        """It is gone."""
        async with self.taken(number) as held:
            return held

    async def tidy(self) -> None:
        """Too many, or too old: those go."""
        now = self._clock()
        waiting = sorted(self._files.values(), key=lambda one: one.since)
        many = waiting[: max(0, len(waiting) - MOST)]
        for held in waiting:
            there = held.id in self._files  # and not let go by somebody else meanwhile
            if there and (held in many or now - held.since > LONGEST):
                await self.let_go(held.id)

    async def tidy_for_ever(self) -> None:
        """So that the last one that was sent goes, too."""
        while True:
            await asyncio.sleep(LOOK_EVERY)
            await self.tidy()

    async def close(self) -> None:
        """All of them."""
        while self._files:
            await self.let_go(next(iter(self._files)))
