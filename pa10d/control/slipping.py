"""Does a joint go on in its closed brake? Then that does not hold what hangs on it.

A load that its brake does not hold goes as soon as power has gone, and downwards: what begins to
move later, or against its load, a hand moves. A joint that goes into its brake with speed is
brought to rest by it first. One that is not heard, or reads elsewhere at once, has not gone there:
its drive began anew, or its encoder jumped.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.control.holding import FELL
from pa10d.control.limits import ArmLimits
from pa10d.control.stop import REST_SPEED
from pa10d.control.whereabouts import GIVE, JUMP

Array = NDArray[np.float64]

WATCHED = 2.0  # s
BEGINS = 0.7  # s within which it has begun to go
LOADED = 0.02  # of its torque limit: less moves no joint
CATCHES = 0.5  # s within which a brake has brought to rest whatever it can hold
LASTS = 3  # cycles


class Slipping:
    """Since power has gone."""

    def __init__(self, limits: ArmLimits, now: float, weight: Array) -> None:
        """now: s; weight: N·m (n,) that would hold each joint."""
        loaded = np.abs(weight) > LOADED * limits.torque
        self._down = np.where(loaded, -np.sign(weight), 0.0)
        self._slow, self._fastest = REST_SPEED * limits.velocity, limits.velocity
        self._far = FELL * limits.following_error
        self._now = self._seen = now
        self._last = np.full(len(self._far), np.nan)  # rad, in the cycle before
        self._at = np.full(len(self._far), np.nan)  # rad, where each was held, or was to be
        self._beyond = np.zeros(len(self._far), dtype=np.int64)
        self._begun = np.zeros(len(self._far), dtype=bool)
        self._told = np.zeros(len(self._far), dtype=bool)

    def over(self, now: float) -> bool:
        """Whether what moves from now on, s, may be moved by somebody."""
        return now - self._now > WATCHED

    def see(
        self,
        now: float,
        q: Array,
        dq: Array,
        age: NDArray[np.int64],
        closed: NDArray[np.bool_],
    ) -> list[tuple[int, float]]:
        """Joints that slip, and by how many rad, each told once. q, dq: (n,) rad, rad/s as read;
        age: cycles since each was fresh; closed: (n,) of which it is sure that they are in their
        brakes."""
        jumps = np.abs(q - self._last) > JUMP * self._fastest * (now - self._seen)
        self._last, self._seen = q.copy(), now
        rests = (np.abs(dq) < self._slow) | (now - self._now > CATCHES)
        self._at[(age != 0) | jumps | ~closed] = np.nan
        self._at = np.where(np.isnan(self._at) & rests & (age == 0) & closed, q, self._at)
        gone = np.nan_to_num(self._down * (q - self._at))
        if now - self._now <= BEGINS:
            self._begun |= gone > GIVE
        gone = np.where(self._begun, gone, 0.0)
        self._beyond = np.where(gone > self._far, self._beyond + 1, 0)
        new = (self._beyond >= LASTS) & ~self._told
        self._told |= new
        return [(int(axis), float(gone[axis])) for axis in np.flatnonzero(new)]
