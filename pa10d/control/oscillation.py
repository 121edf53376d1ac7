"""Does a joint swing up, and how fast? A few numbers a joint and cycle, compiled.

A swing is counted by its halves: between two changes of sign of the speed error, each of at least
``SPEED`` of the speed limit, more than what the motion itself changes its speed by meanwhile, not
smaller than two halves before, and with the servo's torque going to and fro by ``TORQUE`` of its
limit. One of a few counts of the encoder is how a servo looks for an angle between two of them, and
no swing. ``HALVES`` of them in a row are an oscillation; whoever ends the motion earlier asks what
was counted until then. One that grows by half each time has left the envelope before it is counted
often: from two on that is enough.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.control.faults import LoopFault
from pa10d.control.limits import ArmLimits
from pa10d.control.reference import Reference

Array = NDArray[np.float64]

SPEED = 0.05  # of the speed limit
TORQUE = 0.1  # of the torque limit, from one end to the other
OWN = 2.5  # times the change of the desired speed: margins allow no servo to answer with more
FADES = 0.8  # of the half before the last: less is a swing that dies away
STEPS = 2.0  # counts of its encoder, to either side
SLOWEST = 0.5  # Hz
HALVES, SOME, FEW = 10, 4, 2
GROWS = 1.5  # times the half before, twice in a row: collisions and falls do not go to and fro
_ROWS = 11
(_SIGN, _CYCLES, _SPEED, _LEAST, _MOST, _BEFORE, _LAST, _LOW, _HIGH, _LOW_LAST,
 _HIGH_LAST) = range(_ROWS)  # fmt: skip


class OscillationWatch:
    """Counts half swings of every joint."""

    def __init__(self, limits: ArmLimits, period: float) -> None:
        n, self._limits = len(limits.torque), limits
        self._speed, self._torque = SPEED * limits.velocity, TORQUE * limits.torque
        self._longest = 0.5 / (SLOWEST * period)
        self._period = period
        self.grains = np.zeros(n)  # rad of one count of each encoder, 0: as fine as can be
        self._state = np.zeros((_ROWS, n))
        self._count = np.zeros(n, dtype=np.int64)
        self._half = np.zeros((3, n))  # cycles, rad/s, N·m of the last half that counted
        self.watch(np.zeros(n), Reference(n), np.zeros(n))  # compiled before it is needed
        self.restart()

    def watch(self, dq: Array, reference: Reference, torque: Array) -> None:
        """Violation where a joint swings; (n,) rad/s measured, N·m sent."""
        axis = self.see(dq, reference, torque)
        if axis >= 0:
            raise self.violation(axis)

    def see(self, dq: Array, reference: Reference, torque: Array) -> int:
        """Count; the joint that swings, -1: none."""
        servo = torque - reference.extra  # what shakes the joint on purpose does not count
        axis: int = _count(
            dq, reference.dq, servo, self._speed, self._torque, self._longest, OWN, FADES, HALVES,
            np.pi * STEPS / self._period * self.grains, self._state, self._count, self._half,
        )  # fmt: skip
        return axis

    def suspected(self, axis: int) -> bool:
        """Whether a joint that left its envelope swung on its way there."""
        now, last, before = self._state[[_SPEED, _LAST, _BEFORE], axis]
        grows = now >= GROWS * last and last >= GROWS * before > 0.0
        return bool(self._count[axis] >= (FEW if grows else SOME))

    def violation(self, axis: int) -> LoopFault:
        """What to latch."""
        cycles, speed, torque = self._half[:, axis]
        hertz = 0.5 / (max(cycles, 1.0) * self._period)
        said = f"swings at {hertz:.2g} Hz, by ±{speed:.2g} rad/s and ±{0.5 * torque:.2g} N·m"
        return LoopFault("oscillation", self._limits.in_units(axis, said), axis, hertz)

    def restart(self) -> None:
        """Forget the past."""
        self._state[:] = 0.0
        self._count[:] = 0


@numba.njit(cache=True)
def _count(
    dq, asked, torque, fast, strong, longest, own, fades, halves, least, state, count, half
):  # fmt: skip
    found = -1
    for j in range(len(dq)):
        error = dq[j] - asked[j]
        sign = 1.0 if error > 0 else -1.0
        cycles = state[_CYCLES, j]
        if sign != state[_SIGN, j] and (abs(error) > 0.1 * fast[j] or cycles > longest):
            speed, before = state[_SPEED, j], state[_BEFORE, j]
            high, low = state[_HIGH, j], state[_LOW, j]
            swing = max(high, state[_HIGH_LAST, j]) - min(low, state[_LOW_LAST, j])
            counts = (
                cycles <= longest
                and speed >= fast[j]
                and speed * cycles >= least[j]
                and speed >= own * (state[_MOST, j] - state[_LEAST, j])
                and speed >= fades * before
                and swing >= strong[j]
            )
            count[j] = count[j] + 1 if counts else 0
            if counts:
                half[0, j], half[1, j], half[2, j] = cycles, speed, swing
            state[_BEFORE, j], state[_LAST, j] = state[_LAST, j], speed
            state[_SIGN, j], state[_CYCLES, j] = sign, 0.0
            state[_HIGH_LAST, j], state[_LOW_LAST, j] = high, low
            state[_HIGH, j] = state[_LOW, j] = torque[j]
            state[_SPEED, j] = 0.0
            state[_LEAST, j] = state[_MOST, j] = asked[j]
            if count[j] >= halves and found < 0:
                found = j
        state[_CYCLES, j] += 1.0
        state[_SPEED, j] = max(state[_SPEED, j], abs(error))
        state[_LEAST, j] = min(state[_LEAST, j], asked[j])
        state[_MOST, j] = max(state[_MOST, j], asked[j])
        state[_LOW, j] = min(state[_LOW, j], torque[j])
        state[_HIGH, j] = max(state[_HIGH, j], torque[j])
    return found
