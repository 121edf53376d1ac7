"""Does a joint go on in its closed brake? Then that does not hold what hangs on it.

A load that its brake does not hold goes as soon as power has gone, and downwards: what begins to
move later, or against its load, a hand moves. A joint that goes into its brake with speed is
brought to rest by it first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.control.holding import FELL
from pa10d.control.limits import ArmLimits
from pa10d.control.stop import REST_SPEED
from pa10d.control.whereabouts import GIVE, GoneInBrakes

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
        self._slow, self._far = REST_SPEED * limits.velocity, FELL * limits.following_error
        self._gone, self._now = GoneInBrakes(limits), now
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
        rests = (np.abs(dq) < self._slow) | (now - self._now > CATCHES)
        gone = self._down * self._gone.see(now, q, age, closed, rests)
        if now - self._now <= BEGINS:
            self._begun |= gone > GIVE
        gone = np.where(self._begun, gone, 0.0)
        self._beyond = np.where(gone > self._far, self._beyond + 1, 0)
        new = (self._beyond >= LASTS) & ~self._told
        self._told |= new
        return [(int(axis), float(gone[axis])) for axis in np.flatnonzero(new)]
