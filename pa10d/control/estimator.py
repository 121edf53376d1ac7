"""Joint speeds from encoder positions, for the loop; compiled, as it is part of every cycle."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CUTOFF = 50.0  # Hz: an order above the servo's bandwidth, an order below encoder noise at 500 Hz


class SpeedEstimator:
    """First-order low-pass of the encoder's difference over the time that really passed.

    A late cycle then is no fast joint, nor is one that answers for several cycles at once; cycles
    without a fresh value are bridged.
    """

    def __init__(self, n: int, period: float, cutoff: float = CUTOFF) -> None:
        self.dq = np.zeros(n)
        self.q = np.zeros(n)
        self._period, self._rate = period, 2.0 * np.pi * cutoff
        self._one = np.ones(n, dtype=np.int64)
        self._last = np.zeros(n)  # rad, when an axis answered last
        self._seen = np.zeros(n)  # s, and when that was
        self._time = 0.0
        self._started = True
        self.update(self.q.copy(), np.zeros(n, dtype=np.int64), 0.0)  # compiled before it is needed
        self.restart()

    def update(
        self,
        q: Array,
        age: NDArray[np.int64],
        time: float,
        answers: NDArray[np.int64] | None = None,
    ) -> None:
        """q (n,) as read at ``time`` s, age (n,) cycles since it was fresh; answers: see
        ``Feedback``."""
        if self._started:
            _advance(
                q, age, time, time - self._time, self._period, self._rate,
                self.q, self.dq, self._last, self._seen, self._one if answers is None else answers,
            )  # fmt: skip
        else:
            self._started = True
            self._last[:], self.q[:], self._seen[:] = q, q, time
        self._time = time

    def restart(self) -> None:
        """Forget the past; the next update begins anew, at rest."""
        self._started = False
        self.dq[:] = 0.0


@numba.njit(cache=True)
def _advance(read, age, time, passed, period, rate, q, dq, last, seen, answers):
    for j in range(len(q)):
        if age[j] != 0:
            q[j] += passed * dq[j]
            continue
        least = period * (answers[j] if answers[j] > 1 else 0.5)
        gap = max(time - seen[j], least)
        share = 1.0 - math.exp(-rate * gap)
        dq[j] += share * ((read[j] - last[j]) / gap - dq[j])
        q[j] = last[j] = read[j]
        seen[j] = time
