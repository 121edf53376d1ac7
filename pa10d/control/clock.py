"""When a cycle begins: absolute deadlines in real time, no waiting in simulated time."""

from __future__ import annotations

import math
import time

from pa10d.control.punctuality import Punctuality, Starved

LATEST = 0.5  # of a period: a cycle that begins later could not be done before the next is due


class Clock:
    """Keeps deadlines at multiples of the period. A deadline that is passed by too much is given
    up for the next one: two cycles in a row would not fit on the bus."""

    def __init__(self, period: float) -> None:
        self.period = period
        self.late, self.busy = 0.0, 0.0
        self.missed = 0  # deadlines given up, and cycles that were not done within their period
        self._punctuality = Punctuality(period)
        self._paced = False
        self._deadline = time.monotonic()
        self._began = 0.0

    def wait(self, paced: bool) -> None:
        """Until the next deadline; at once where not paced."""
        now = time.monotonic()
        self._deadline += self.period
        self._paced, first = paced, self._deadline
        if not paced:
            self._deadline = now
        while paced:
            passed = math.ceil((now - self._deadline) / self.period - LATEST)
            if passed > 0:
                self.missed += passed
                self._deadline += passed * self.period
            if now >= self._deadline:
                break
            time.sleep(self._deadline - now)
            now = time.monotonic()
        self.late = now - self._deadline
        if paced:
            self._punctuality.note(now - first)
        self._began = time.thread_time()

    def done(self) -> None:
        """The cycle is over."""
        self.busy = time.thread_time() - self._began
        if time.monotonic() > self._deadline + self.period:
            self.missed += 1

    def starved(self) -> Starved | None:
        """Whether the last second's cycles, this one among them, came too late to hold an arm."""
        if not self._paced:
            return None
        return self._punctuality.starved(time.monotonic() - self._deadline - self.period)

    def restart(self) -> None:
        """After something that was allowed to take long."""
        self._deadline = time.monotonic()
