"""Joint speeds from encoder positions, for the loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CUTOFF = 50.0  # Hz: an order above the servo's bandwidth, an order below encoder noise at 500 Hz


class SpeedEstimator:
    """First-order low-pass of the encoder's difference over the time that really passed.

    A late cycle then is no fast joint, and cycles without a fresh value are bridged.
    """

    def __init__(self, n: int, period: float, cutoff: float = CUTOFF) -> None:
        self.dq = np.zeros(n)
        self.q = np.zeros(n)
        self._period, self._rate = period, 2.0 * np.pi * cutoff
        self._last = np.zeros(n)  # rad, when an axis answered last
        self._seen = np.zeros(n)  # s, and when that was
        self._time = 0.0
        self._whole = False  # every axis answered in the cycle before
        self._started = False

    def update(self, q: Array, age: NDArray[np.int64], time: float) -> None:
        """q (n,) as read at ``time`` s, age (n,) cycles since it was fresh."""
        fresh = age == 0
        whole = bool(fresh.all())
        if not self._started:
            self._started = True
            self._last[:], self.q[:], self._seen[:] = q, q, time
        elif whole and self._whole:
            dt = max(time - self._time, 0.5 * self._period)
            share = 1.0 - np.exp(-self._rate * dt)
            self.dq += share * ((q - self._last) / dt - self.dq)
            self.q[:], self._last[:], self._seen[:] = q, q, time
        else:
            self._bridge(q, fresh, time)
        self._time, self._whole = time, whole

    def restart(self) -> None:
        """Forget the past; the next update begins anew, at rest."""
        self._started = False
        self.dq[:] = 0.0

    def _bridge(self, q: Array, fresh: NDArray[np.bool_], time: float) -> None:
        gap = np.maximum(time - self._seen, 0.5 * self._period)
        share = 1.0 - np.exp(-self._rate * gap)
        self.dq += np.where(fresh, share * ((q - self._last) / gap - self.dq), 0.0)
        self.q[:] = np.where(fresh, q, self.q + (time - self._time) * self.dq)
        self._last[fresh] = q[fresh]
        self._seen[fresh] = time
