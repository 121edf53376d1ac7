"""What of a joint's dry friction its integral holds while it waits.

A joint that creeps slides: its friction is against the way it creeps, and the integral holds it.
Measured friction comes on top, by the way the joint is to move (``torque_ahead``): sent the other
way, it would be short of all that it held. So that is let go as its motion begins. How far it crept
tells the share, by the stop model: between -1 and 1 times friction, full after ``CREPT``. While it
stands, friction balances the torque: what the torque changes by, the share does, too. Where a joint
has not crept, or slipped, nobody knows, and nothing is let go, unless it is known what the arm
weighs: what its torque is less that is friction. Where a motion waits on its way its own torque
bears what the weight changed by, as well as that is known: friction is no more than the rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CREPT = 1e-3  # rad after which a joint slides, whatever its gear gives way by
SLIPS = 0.02  # rad/s: what held such a joint when it stopped nobody knows
STANDS = 1e-3  # rad/s, slower than which it does not creep
LET_GO = 0.05  # s


class HeldFriction:
    """Of all joints; a joint moves where its reference does, else it waits.

    coulomb: (n,) N·m as measured, 0 where it was not; period: s.
    """

    def __init__(self, coulomb: Array, period: float) -> None:
        self.known = bool(coulomb.any())
        self._period = period
        self._coulomb, self._share = coulomb, min(1.0, period / LET_GO)
        self._crept, self._last = np.zeros_like(coulomb), np.zeros_like(coulomb)
        self._sent = np.zeros_like(coulomb)
        self._moved = np.zeros_like(coulomb, dtype=bool)  # its reference, in the cycle before
        self._weight: tuple[Array, Array] | None = None  # N·m, where this motion began

    def start(self, q: Array, torque: Array) -> None:
        """Nothing is known yet; (n,) rad, N·m."""
        self._weight = None
        self._crept, self._last, self._sent = np.zeros_like(q), q.copy(), torque.copy()

    def let_go(self, q: Array, dq: Array, moving: Array, torque: Array) -> Array:
        """(n,) N·m by which the integral gets less in this cycle.

        q: (n,) rad; dq: (n,) rad/s; moving: (n,) whether the reference moves; torque: (n,) N·m
        that the servo gave last, without what a motion brings along: that is the load's.
        """
        if self._weight is not None and (begins := moving & ~self._moved).any():
            low, high = self._friction(torque, *self._weight)
            no_more = np.clip(self._crept, np.minimum(low, 0.0), np.maximum(high, 0.0))
            self._crept = np.where(begins, no_more, self._crept)
        self._moved = moving.copy()
        gone = moving * self._share * self._crept
        stands = (np.abs(q - self._last) < STANDS * self._period) * (self._crept != 0.0)
        more = (torque - self._sent) / np.where(self._coulomb > 0.0, self._coulomb, np.inf)
        further = self._crept + (q - self._last) / CREPT + stands * more
        waits = np.where(np.abs(dq) < SLIPS, np.clip(further, -1.0, 1.0), 0.0)
        self._crept = np.where(moving, self._crept - gone, waits)
        self._last[:], self._sent[:] = q, torque
        return np.asarray(self._coulomb * gone)

    def weighed(self, torque: Array, low: Array, high: Array) -> None:
        """A motion begins: each joint weighs ``low`` to ``high`` (n,) N·m here, ``torque`` (n,) N·m
        holds it. No more counts as friction than must be, no less than can be."""
        self._weight = low, high
        held = np.clip(self._crept, *self._friction(torque, low, high))
        self._crept = np.clip(held, -1.0, 1.0)

    def _friction(self, torque: Array, low: Array, high: Array) -> tuple[Array, Array]:
        """Least and most share of it, (n,), that ``torque`` (n,) N·m holds beside such weights."""
        whole = np.where(self._coulomb > 0.0, self._coulomb, np.inf)
        return (torque - high) / whole, (torque - low) / whole

    def absorb(self, extra: Array) -> None:
        """N·m (n,) that the servo gives from now on, and a motion gave before."""
        self._sent += extra
