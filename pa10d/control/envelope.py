"""Is every axis where it may be? Compiled: forty microseconds of numpy calls become two."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.control.faults import LoopFault
from pa10d.control.limits import ArmLimits
from pa10d.control.outside import Reach

Array = NDArray[np.float64]

OVERSPEED = 1.2  # of the velocity limit: the estimate has noise, a runaway passes this at once
OVERSHOOT = 0.02  # rad beyond a position limit, braking distance included
PERSISTS = 8e-3  # s that a speed must look too high: one late cycle is no fast joint …
FEWEST = 2  # … nor is it in a slow loop; but an arm that swings must not hide between its cycles

_FINE, _STALE, _FAST, _OUTSIDE, _AWAY = range(5)
_SAYS = {
    _STALE: ("stale", "no news for {:.0f} cycles"),
    _FAST: ("velocity_limit", "moves at {:.3g} rad/s, more than it may"),
    _OUTSIDE: ("position_limit", "would stop at {:.4g} rad, beyond its limit"),
    _AWAY: ("following_error", "is {:.3g} rad from where it should be"),
}


class Envelope:
    """Position with braking distance, speed, following error and freshness of every live axis."""

    def __init__(self, limits: ArmLimits, period: float, reach: Reach) -> None:
        """reach: positions that are allowed now; whoever owns it has it follow the arm."""
        self.limits, self._reach = limits, reach
        self._persists = max(FEWEST, round(PERSISTS / period))  # cycles
        self._fast = OVERSPEED * limits.velocity
        self._brake = 0.5 / limits.acceleration
        self._counts = np.zeros((2, len(limits.torque)), dtype=np.int64)
        still = np.zeros(len(limits.torque))
        self.watch(still, still, still.astype(np.int64), still, np.zeros(len(still), dtype=bool))

    def watch(
        self, q: Array, dq: Array, age: NDArray[np.int64], wanted: Array, live: NDArray[np.bool_]
    ) -> None:
        """Violation where a live axis has left the envelope; (n,) rad, rad/s, cycles, rad."""
        kind, axis, value = _first_violation(
            q, dq, age, wanted, live, self._reach.lower, self._reach.upper, self._fast, self._brake,
            self.limits.following_error, self.limits.stale_cycles, self._persists, self._counts,
        )  # fmt: skip
        if kind != _FINE:
            name, says = _SAYS[kind]
            raise LoopFault(name, self.limits.in_units(axis, says.format(value)), axis)


@numba.njit(cache=True)
def _first_violation(
    q, dq, age, wanted, live, lower, upper, fast, brake, following, stale, persists, counts
):  # fmt: skip
    found, where, what = _FINE, -1, 0.0
    for j in range(len(q)):
        counts[0, j] = counts[0, j] + 1 if abs(dq[j]) > fast[j] else 0
        stop = q[j] + dq[j] * abs(dq[j]) * brake[j]
        above, below = stop > upper[j] + OVERSHOOT, stop < lower[j] - OVERSHOOT
        outside = (above and dq[j] >= 0) or (below and dq[j] <= 0)
        counts[1, j] = counts[1, j] + 1 if outside else 0
        error = wanted[j] - q[j]
        if not live[j] or found != _FINE:
            continue
        if age[j] > stale:
            found, where, what = _STALE, j, float(age[j])
        elif counts[0, j] >= persists:
            found, where, what = _FAST, j, dq[j]
        elif counts[1, j] >= persists:
            found, where, what = _OUTSIDE, j, stop
        elif not abs(error) <= following[j]:  # also where a position is no number
            found, where, what = _AWAY, j, error
    return found, where, what
