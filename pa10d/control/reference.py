"""Where the arm shall be in this cycle: a pose to hold, a motion to follow, a way to rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Reference:
    """(n,) each: rad, rad/s, rad/s², and N·m that the controller's own model does not know."""

    def __init__(self, n: int) -> None:
        self.q, self.dq, self.ddq, self.extra = (np.zeros(n) for _ in range(4))

    def rest(self, q: Array) -> None:
        """Stand at q."""
        self.q[:] = q
        self.dq[:] = 0.0
        self.ddq[:] = 0.0
        self.extra[:] = 0.0


class MotionUnderWay:
    """A sampled motion: rows (N, 4n) of q, dq, ddq, extra at the loop's rate.

    Rows ``first`` … ``last``-1 are what a run of it records; before them lies the way to its start.
    weight: (2, n) N·m, least and most, that the joints may weigh where it begins; None: not known.
    """

    def __init__(
        self,
        number: int,
        rows: Array,
        first: int = 0,
        last: int | None = None,
        weight: Array | None = None,
    ) -> None:
        self.number, self.rows, self.weight = number, rows, weight
        self.first, self.last = first, len(rows) if last is None else last
        self.row = 0

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.rows.shape[1] // 4

    @property
    def start(self) -> Array:
        """(n,) rad, where the arm must stand to begin."""
        return np.array(self.rows[0, : self.n])

    @property
    def finished(self) -> bool:
        """Whether every row was followed."""
        return self.row >= len(self.rows)

    @property
    def recording(self) -> bool:
        """Whether the row taken last belongs to the run."""
        return self.first < self.row <= self.last

    def advance(self, out: Reference) -> None:
        """Take the next row."""
        n, row = self.n, self.rows[self.row]
        out.q[:], out.dq[:], out.ddq[:] = row[:n], row[n : 2 * n], row[2 * n : 3 * n]
        out.extra[:] = row[3 * n :]
        self.row += 1


class Braking:
    """From a pose and speed to rest, every joint at its own acceleration limit.

    The motion's own torque stays as it is: most of it holds the arm against gravity.
    """

    def __init__(self, acceleration: Array, speed: Array, period: float) -> None:
        self._acceleration, self._period = acceleration, period
        self.duration = float(np.max(np.abs(speed) / acceleration, initial=0.0))

    def advance(self, out: Reference) -> bool:
        """One period on, exactly; True once every joint rests."""
        if not out.dq.any():
            out.ddq[:] = 0.0
            return True
        before = out.dq.copy()
        step = self._acceleration * self._period
        out.dq[:] = np.sign(before) * np.maximum(np.abs(before) - step, 0.0)
        moving = np.minimum(np.abs(before) / step, 1.0) * self._period  # time until it rests
        out.q += 0.5 * (before + out.dq) * moving
        out.ddq[:] = np.where(out.dq == 0.0, 0.0, -np.sign(before) * self._acceleration)
        return False
