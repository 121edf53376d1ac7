"""What happened, in order, for everybody who listens; the last ones are kept for latecomers."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator
from datetime import UTC, datetime
from typing import Any

KEPT = 1000
QUEUE = 1000

Event = dict[str, Any]


class Events:
    """``publish`` never waits; a listener that does not keep up misses events and sees a gap."""

    def __init__(self) -> None:
        self._kept: deque[Event] = deque(maxlen=KEPT)
        self._listeners: set[asyncio.Queue[Event]] = set()
        self._number = 0

    def publish(self, kind: str, data: Any) -> None:
        """kind: robot, job, run, lease, process."""
        self._number += 1
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        event = {"number": self._number, "time": now, "kind": kind, "data": data}
        self._kept.append(event)
        for queue in self._listeners:
            if not queue.full():
                queue.put_nowait(event)

    def since(self, number: int) -> list[Event]:
        """Kept events after this number."""
        return [event for event in self._kept if event["number"] > number]

    async def listen(self, since: int | None = None) -> AsyncIterator[Event]:
        """Events from now on; with ``since`` those after it first."""
        queue: asyncio.Queue[Event] = asyncio.Queue(QUEUE)
        self._listeners.add(queue)
        try:
            for event in self.since(since) if since is not None else ():
                yield event
            while True:
                yield await queue.get()
        finally:
            self._listeners.discard(queue)
