"""What happened, in order, for everybody who listens; the last ones are kept for latecomers.

An event is written as JSON once, however many listen.
"""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import AsyncIterator
from datetime import UTC, datetime
from typing import Any

KEPT = 1000
LARGEST = 16 << 20  # characters that are kept
QUEUE = 1000


class Events:
    """``publish`` never waits; a listener that does not keep up misses events and sees a gap."""

    def __init__(self) -> None:
        self._kept: deque[tuple[int, str]] = deque()
        self._size = 0  # characters kept
        self._listeners: set[asyncio.Queue[str]] = set()
        self._number = 0

    def publish(self, kind: str, data: Any) -> None:
        """kind: robot, job, run, model, lease, profile, investigation, story."""
        self._number += 1
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        event = json.dumps({"number": self._number, "time": now, "kind": kind, "data": data})
        self._kept.append((self._number, event))
        self._size += len(event)
        while len(self._kept) > KEPT or (self._size > LARGEST and len(self._kept) > 1):
            self._size -= len(self._kept.popleft()[1])
        for queue in self._listeners:
            if not queue.full():
                queue.put_nowait(event)

    @property
    def listeners(self) -> int:
        """How many listen."""
        return len(self._listeners)

    def since(self, number: int) -> list[str]:
        """Kept events after this number."""
        return [event for its, event in self._kept if its > number]

    async def listen(self, since: int | None = None) -> AsyncIterator[str]:
        """Events as JSON from now on; with ``since`` those after it first."""
        queue: asyncio.Queue[str] = asyncio.Queue(QUEUE)
        self._listeners.add(queue)
        try:
            for event in self.since(since) if since is not None else ():
                yield event
            while True:
                yield await queue.get()
        finally:
            self._listeners.discard(queue)
