"""One client commands the arm at a time. Others may look, and stop it always."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from pa10d.common.jsonable import JsonObject

USUAL = 30.0  # s after the last command of a client that did not ask for a lease
LONGEST = 3600.0  # s


class Held(Exception):
    """Somebody else commands the arm."""

    def __init__(self, holder: str, seconds: float) -> None:
        super().__init__(f"{holder} commands the arm, for another {seconds:.0f} s at most")
        self.holder, self.seconds = holder, seconds


@dataclass
class Lease:
    """Who commands, and until when on ``clock``. ``busy`` keeps it alive (an experiment runs)."""

    busy: Callable[[], bool]
    clock: Callable[[], float] = time.monotonic
    holder: str | None = None
    until: float = 0.0

    def current(self) -> str | None:
        """Whoever commands now."""
        if self.holder is not None and self.clock() > self.until:
            if self.busy():
                self.until = self.clock() + USUAL
            else:
                self.holder = None
        return self.holder

    def take(self, client: str, seconds: float = USUAL) -> None:
        """Take or prolong it; every command does so by itself. Held where another has it."""
        current = self.current()
        if current is not None and current != client:
            raise Held(current, self.until - self.clock())
        keep = self.until if current == client else 0.0
        self.holder = client
        self.until = max(keep, self.clock() + min(seconds, LONGEST))

    def release(self, client: str) -> bool:
        """Give it back; only the holder can."""
        if self.current() != client:
            return False
        self.holder = None
        return True

    def document(self) -> JsonObject:
        """For clients."""
        holder = self.current()
        left = max(0.0, self.until - self.clock()) if holder else 0.0
        return {"holder": holder, "expires_in": round(left, 1)}
