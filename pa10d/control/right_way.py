"""Whose torque acts the right way round? Of whoever went there and back as its servo wanted.

A joint whose torque has the wrong sign may stand, for friction holds it, and it may go one way as
it wants, for it falls that way. It follows no servo both ways.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FAR = 0.03  # rad, less than which may be play, a spring, or a neighbour that shakes it
NEAR = 0.5  # of the way that it was led, by which it may be behind


class RightWay:
    """(n,) ``known``: of each joint, from the motion on that showed it."""

    def __init__(self, n: int) -> None:
        self.known = np.zeros(n, dtype=bool)
        self._doubted = np.zeros(n, dtype=bool)  # since it was known last
        self._ends = np.zeros((2, n))  # rad, the lowest and highest that each was led to since …
        self._went = np.zeros((2, n), dtype=bool)  # … it turned; whether it went down, up with that
        self.begin(np.zeros(n))

    def connected(self, measured: bool, doubted: Collection[int] = ()) -> None:
        """The drives are there, measured: their joints were, some time. What has spoken against one
        since counts more, until it has gone there and back; doubted: of the axes for which somebody
        has kept that, whoever saw it."""
        self._doubted[list(doubted)] = True
        self.known[:] = measured & ~self._doubted

    @property
    def doubted(self) -> tuple[int, ...]:
        """The axes of which something has spoken against it, and nothing for it since."""
        return tuple(map(int, np.flatnonzero(self._doubted)))

    def begin(self, q: Array) -> None:
        """A motion begins at q."""
        self._ends[:] = q
        self._went[:] = False

    def doubt(self, axis: int) -> None:
        """Something speaks against it."""
        self.known[axis] = False
        self._doubted[axis] = True
        self._went[:, axis] = False

    def see(self, wanted: Array, q: Array) -> bool:
        """One cycle of a motion, (n,) rad where each joint shall be and where it is. Whether more
        is known now."""
        if self.known.all():
            return False
        low, high = self._ends
        down, up = high - wanted, wanted - low
        fell, rose = down >= FAR, up >= FAR
        off = np.abs(wanted - q)
        self._went[0] |= fell & (off <= NEAR * down)
        self._went[1] |= rose & (off <= NEAR * up)
        low[:] = np.where(fell, wanted, np.minimum(low, wanted))
        high[:] = np.where(rose, wanted, np.maximum(high, wanted))
        before = self.known.sum()
        self.known |= self._went.all(axis=0)
        self._doubted &= ~self.known
        return bool(self.known.sum() > before)
