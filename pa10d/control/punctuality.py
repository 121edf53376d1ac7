"""How late the last second's cycles came, and whether that explains what the arm did."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

WINDOW = 1.0  # s before a fault in which late cycles may be its cause
LONG = 0.02  # s; in less the last torque, held, takes no joint far
OFTEN = 0.05  # of the cycles, that may come more than a period late
KEPT = 0.99  # of the cycles, that shall come within half a period at the rate that is offered
RATES = (500, 400, 250, 200, 125, 100, 50)  # Hz


@dataclass(frozen=True)
class Starved:
    """late of so many cycles, s the latest, Hz asked for, Hz that this machine kept (or None)."""

    late: int
    cycles: int
    latest: float
    rate: float
    kept: int | None

    @property
    def cause(self) -> str:
        """What to tell instead of what followed from it."""
        return (
            f"{self.late} of {self.cycles} cycles came late, by up to {1e3 * self.latest:.0f} ms: "
            f"this machine does not keep {self.rate:g} Hz"
        )

    @property
    def remedy(self) -> str:
        """What to do."""
        lower = f"lower control.rate to {self.kept}, " if self.kept else ""
        return f"{lower}end other programs, allow real-time priority (pa10d check says how)"


class Punctuality:
    """``note`` every cycle's delay, s."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._delays: deque[float] = deque(maxlen=max(round(WINDOW / period), 2))

    def note(self, delay: float) -> None:
        """A cycle began this much after its first deadline."""
        self._delays.append(delay)
        for _ in range(min(round(delay / self._period), self._delays.maxlen or 0)):
            self._delays.append(0.0)  # cycles that never were: a second stays a second

    def starved(self, now: float = 0.0) -> Starved | None:
        """None where delays explain nothing. ``now``: s by which this cycle is over its time."""
        delays = [*self._delays, now]
        late = [delay for delay in delays if delay > self._period]
        latest = max(delays)
        if latest < LONG and len(late) < OFTEN * len(delays):
            return None
        ordered = sorted(delays)
        most = ordered[min(int(KEPT * len(ordered)), len(ordered) - 1)]
        rate = 1.0 / self._period
        fitting = (r for r in RATES if r < 0.99 * rate and most < 0.5 / r)
        return Starved(len(late), len(delays), latest, rate, next(fitting, None))
