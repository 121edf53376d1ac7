"""Does a torque act the wrong way round? Seen in the closed brake, before that opens.

A drive is under power for a moment before its brake is open, and a brake gives way a little, as
hubs and gears do: to what comes up now, and that way, for its load was there before. One that goes
the other way has its torque turned round, and nothing has fallen yet. A drive that turns its rotor
to find its phases may go any way: it does so once. What is too little to be sure tells how it is
to be stopped should it fall: by its brake, not by its drive.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from pa10d.control.faults import LoopFault

Array = NDArray[np.float64]

KEPT, FEWEST = 16, 8  # cycles of rest, before its drive was told, that say where it stood
COUNTS, SURE = 3.0, 6.0  # of its encoder, and standard deviations of that rest, it must go at least
PUSHED = 0.02  # of the torque limit
SHAKES = 0.3  # of its way, by which another may move, and the arm rest all the same
FOR = 2  # cycles
LEANS, LASTS = 1.5, 3  # counts beyond all that it read at rest, and cycles: less than sure
ROUNDING = 1e-12  # rad


class InBrake:
    """``see`` in every cycle; ``goes_against`` while one joint's brake is to open alone."""

    def __init__(self, strongest: Array) -> None:
        """strongest: (n,) N·m, the torque limits."""
        self._least = PUSHED * strongest
        self._rest: deque[Array] = deque(maxlen=KEPT)
        self._last: Array | None = None
        self._count = np.full(len(strongest), np.inf)  # rad of one count, as far as was seen
        self._axis: int | None = None
        self._cycles = 0
        self._before: set[int] = set()  # that did so already
        self._beyond = 0  # cycles
        self.leaning: set[int] = set()  # that did so by less than is sure, since the arm is powered

    def restart(self) -> None:
        """The arm is powered up."""
        self._axis, self._cycles, self._beyond = None, 0, 0
        self._before.clear()
        self.leaning.clear()

    @property
    def counts(self) -> Array:
        """(n,) rad of one count of each encoder, as far as that was seen; 0: it was not."""
        return np.where(np.isfinite(self._count), self._count, 0.0)

    def see(self, q: Array, age: NDArray[np.int64]) -> None:
        """(n,) rad as read in this cycle, and cycles since each was fresh."""
        if self._last is not None:
            moved = np.abs(q - self._last)
            seen = (moved > ROUNDING) & (age == 0)
            self._count = np.where(seen, np.minimum(self._count, moved), self._count)
        self._last = q.copy()
        if self._axis is None:
            self._rest.append(self._last)

    def goes_against(
        self, axis: int | None, torque: Array, age: NDArray[np.int64], closed: NDArray[np.bool_]
    ) -> bool:
        """Whether the joint whose brake is to open goes against its torque, and is to be looked at
        once more; violation where it did so before. axis: that joint, None while all brakes close;
        torque: (n,) N·m sent; closed: (n,) of which brakes it is sure that they are not open."""
        if axis is not None and axis != self._axis and not closed[axis]:
            axis = None  # it has no brake
        if axis != self._axis:
            self._axis, self._cycles, self._beyond = axis, 0, 0
        if axis is None or len(self._rest) < FEWEST or age[axis] != 0:
            return False
        way = self._against(axis, float(torque[axis])) if closed[axis] else 0.0
        if closed[axis]:
            self._lean(axis, float(torque[axis]))
        self._cycles = self._cycles + 1 if way > 0.0 else 0
        if self._cycles < FOR:
            return False
        if axis not in self._before:
            self._before.add(axis)
            self._cycles = 0
            return True
        raise LoopFault(
            "wrong_sign",
            f"was pushed by {abs(torque[axis]):.2g} N·m in its closed brake and went the other "
            f"way, by {way:.2g} rad, twice: its torque acts the wrong way round",
            axis,
        )

    def _lean(self, axis: int, push: float) -> None:
        rest, now = np.array(self._rest)[:, axis], float(np.asarray(self._last)[axis])
        beyond = float(rest.min()) - now if push > 0.0 else now - float(rest.max())
        little = abs(push) < self._least[axis] or beyond <= LEANS * self._count[axis]
        self._beyond = 0 if little else self._beyond + 1
        if self._beyond >= LASTS:
            self.leaning.add(axis)

    def _against(self, axis: int, push: float) -> float:
        """rad that it surely went the other way, 0 where that is not sure."""
        rest, now = np.array(self._rest), self._last
        assert now is not None
        way, noise = now - rest.mean(axis=0), rest.std(axis=0)
        far = abs(float(way[axis]))
        if abs(push) < self._least[axis] or way[axis] * push >= 0.0:
            return 0.0
        if far <= COUNTS * self._count[axis] + SURE * noise[axis]:
            return 0.0
        others = np.delete(np.abs(way), axis)
        return 0.0 if (others > SHAKES * far).any() else far
