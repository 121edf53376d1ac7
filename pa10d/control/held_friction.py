"""What of a joint's dry friction its integral holds while it waits.

A joint that creeps slides: its friction is against the way it creeps, and the integral holds it.
Measured friction comes on top, by the way the joint is to move (``torque_ahead``): sent the other
way, it would be short of all that it held. So that is let go as its motion begins. How far it crept
tells the share, by the stop model: between -1 and 1 times friction, full after ``CREPT``. One that
slides gives way as its servo pulls, and torque does not rise with its way: as much of a creep as
torque rose by instead is none, for friction took that up. Friction of some gears creeps from the
first on, at a milliradian a second under a third of it. While a joint stands, friction balances the
torque: what the torque changes by, the share does, too. Where it has not crept, or slipped, nobody
knows, and nothing is let go, unless it is known what the arm weighs: what its torque is less that
is friction. Where a motion waits on its way its own torque bears what the weight changed by, as
well as that is known: friction is no more than the rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CREPT = 1e-3  # rad after which a joint slides, whatever its gear gives way by
SLIPS = 0.02  # rad/s: what held such a joint when it stopped nobody knows
STANDS = 1e-3  # rad/s, slower than which it does not creep
LET_GO = 0.05  # s
BY_NOW = 0.5  # s in which way and torque are compared: many steps of a coarse encoder
NONE = 1e-12  # N·m


class HeldFriction:
    """Of all joints; a joint moves where its reference does, else it waits.

    coulomb: (n,) N·m as measured, 0 where it was not; period: s; stiff: (n,) N·m/rad of its servo.
    """

    def __init__(self, coulomb: Array, period: float, stiff: Array) -> None:
        self.known = bool(coulomb.any())
        self._period, self._stiff, self._fades = period, stiff, np.exp(-period / BY_NOW)
        self._coulomb, self._share = coulomb, min(1.0, period / LET_GO)
        self._crept, self._last = np.zeros_like(coulomb), np.zeros_like(coulomb)
        self._sent = np.zeros_like(coulomb)
        self._way, self._rose = np.zeros_like(coulomb), np.zeros_like(coulomb)  # rad, N·m, by now
        self._moved = np.zeros_like(coulomb, dtype=bool)  # its reference, in the cycle before
        self._weight: tuple[Array, Array] | None = None  # N·m, where this motion began

    def start(self, q: Array, torque: Array) -> None:
        """Nothing is known yet; (n,) rad, N·m."""
        self._weight = None
        self._way[:] = self._rose[:] = 0.0
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
        way, more = q - self._last, torque - self._sent
        stands = (np.abs(way) < STANDS * self._period) * (self._crept != 0.0)
        slid = self._slides(way, more, moving) * way / CREPT
        further = self._crept + slid + stands * self._share_of(more)
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
        return self._share_of(torque - high), self._share_of(torque - low)

    def _share_of(self, torque: Array) -> Array:
        return torque / np.where(self._coulomb > 0.0, self._coulomb, np.inf)

    def _slides(self, way: Array, more: Array, moving: Array) -> Array:
        """(n,) share of a creep that is sliding: what its servo gave way by, of that and of what
        torque rose by. way: rad, more: N·m, since the cycle before."""
        went = self._fades * self._way + 0.5 * way  # a step of an encoder has taken its time
        self._way = np.where(moving, 0.0, went + 0.5 * way)
        self._rose = np.where(moving, 0.0, self._fades * self._rose + more)
        gave = self._stiff * np.abs(went)
        rose = np.maximum(self._rose * np.sign(went), 0.0)
        return np.asarray(gave / np.maximum(gave + rose, NONE))

    def absorb(self, extra: Array) -> None:
        """N·m (n,) that the servo gives from now on, and a motion gave before."""
        self._sent += extra
