"""What a joint weighs that was not held as its brake opened, from how it fell.

The servo pushes back meanwhile, so that torque changes and tells inertia and weight apart:
J·v' = u - w, so v = b + a·t + c·∫(u - u0)dt with c = 1/J and w = u0 - a/c. Dry friction acts
against the fall: w is what is lacking beside it, and holds the joint. Viscous friction lets w look
smaller. Of joints that another one takes along it says nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEFT = 1e-3  # rad from its place, before which a gear's play may be all that moves
FEWEST = 5  # periods: three numbers are fitted
SURE = 3.0  # standard errors
LACKING = 0.5  # of what was lacking, that may be lacking or too much next time
KEPT = 1024  # cycles: falls are shorter


@dataclass(frozen=True)
class Weighed:
    """torque, error: N·m that hold a joint where it fell, and their standard error."""

    torque: float
    error: float


class FallWatch:
    """The last cycles of an arm that is powered up and has not been moved yet."""

    def __init__(self, n: int) -> None:
        self._rows, self._count = np.zeros((KEPT, 1 + 2 * n)), 0
        self._n = n

    def restart(self) -> None:
        """The brakes are about to open."""
        self._count = 0

    def see(self, time: float, q: Array, sent: Array) -> None:
        """s and (n,) rad as read in this cycle; N·m sent in the one before, which act from now on,
        for drives take them over with this cycle's SYNC."""
        row = self._rows[self._count % KEPT]
        row[0], row[1 : 1 + self._n], row[1 + self._n :] = time, q, sent
        self._count += 1

    def weighed(self, axis: int, thought: float, most: float) -> Weighed | None:
        """Of a joint that fell under ``thought`` N·m; None where that is not known well enough to
        come nearer, or more than the ``most`` that it may weigh."""
        rows = self._rows[np.arange(max(0, self._count - KEPT), self._count) % KEPT]
        found = weight_of(rows[:, 0], rows[:, 1 + axis], rows[:, 1 + self._n + axis])
        if found is None or abs(found.torque) > most:
            return None
        near = SURE * found.error <= LACKING * abs(found.torque - thought)
        return found if near else None


def weight_of(time: Array, q: Array, sent: Array) -> Weighed | None:
    """time: (N,) s; q: (N,) rad; sent: (N,) N·m that act from then on. None where it cannot be
    told, or where torque does not push the way it should."""
    away = np.flatnonzero(np.abs(q - q[0]) > LEFT) if len(q) else np.zeros(0, dtype=np.int64)
    if not len(away):
        return None
    gap, fall = np.diff(time), slice(int(away[0]), None)
    more = gap * (sent[:-1] - sent[0])
    pushed = np.cumsum(more) - 0.5 * more
    middle, speed = 0.5 * (time[1:] + time[:-1]) - time[0], (np.diff(q) / gap)[fall]
    columns = np.stack([np.ones_like(middle), middle, pushed], axis=1)[fall]
    if len(columns) < FEWEST:
        return None
    found = np.linalg.lstsq(columns, speed, rcond=None)[0]
    left, (_, a, c) = speed - columns @ found, found
    noise = float(left @ left) / (len(columns) - len(found))
    covariance = noise * np.linalg.pinv(columns.T @ columns)
    if not c > SURE * np.sqrt(covariance[2, 2]):
        return None
    slope = np.array([0.0, -1.0 / c, a / c**2])
    return Weighed(float(sent[0] - a / c), float(np.sqrt(slope @ covariance @ slope)))
