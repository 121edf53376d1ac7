"""When a cycle begins: absolute deadlines in real time, no waiting in simulated time."""

from __future__ import annotations

import time


class Clock:
    """Keeps deadlines at multiples of the period; a cycle that overruns skips whole periods."""

    def __init__(self, period: float) -> None:
        self.period = period
        self.late, self.busy, self.missed = 0.0, 0.0, 0
        self._deadline = time.monotonic()
        self._began = 0.0

    def wait(self, paced: bool) -> None:
        """Until the next deadline; at once where not paced."""
        now = time.monotonic()
        self._deadline += self.period
        if not paced:
            self._deadline = now
        elif now < self._deadline:
            time.sleep(self._deadline - now)
            now = time.monotonic()
        elif now - self._deadline > self.period:
            skipped = int((now - self._deadline) / self.period)
            self._deadline += skipped * self.period
        self.late = now - self._deadline
        self._began = time.thread_time()

    def done(self) -> None:
        """The cycle is over."""
        self.busy = time.thread_time() - self._began
        if time.monotonic() > self._deadline + self.period:
            self.missed += 1

    def restart(self) -> None:
        """After something that was allowed to take long."""
        self._deadline = time.monotonic()
