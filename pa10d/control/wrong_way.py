"""Does a torque act the wrong way round? Seen while a joint is held, before it has gone far.

A joint that something pushes away slows down as the servo pushes back. Where it goes away faster
the more the servo pushes back, its torque has the wrong sign. Since it left its place the speed is
a·t + c·∫(u - u0)dt: c is 1/J, or -1/J. Least squares, five sums a joint. One that leans over, and
by that weighs more than it is pushed back by, goes faster, too: nothing is said of it. Another
joint that moves about as fast, pushed or falling, may take it along: until it rests again nothing
is said of it. Nor is it of one that comes back before: a torque of the wrong sign only drives a
joint away; a neighbour sways. And what hardly moves tells of the brake that it slips in, or of
friction: it counts from there on.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.control.faults import LoopFault

Array = NDArray[np.float64]

LEFT, FAR = 1e-3, 0.01  # rad: where it begins, and what is enough to judge
SURE = 6.0  # standard errors
BACK = 0.02  # rad/s, by which a joint comes back to its place, or moves another; slower ones stand
PUSHED = 0.02  # of the torque limit: friction alone moves a joint in ways of its own
FEWEST = 8  # cycles
TAKES = 0.3  # of a joint's speed, with which another may take it along
_ROWS = 10
_TIME, _PUSH, _FROM, _TT, _TP, _PP, _TV, _PV, _VV, _STOOD = range(_ROWS)


class WrongWayWatch:
    """One row of sums per joint; joints are looked at that were in their place before."""

    def __init__(self, strongest: Array, period: float, leans: Array | None = None) -> None:
        """strongest: (n,) N·m, the torque limits; leans: (n,) N·m/rad, by which a joint's weight
        changes at most as it turns, None: not at all."""
        n = len(strongest)
        self._period, self._least = period, PUSHED * strongest
        self._leans = np.zeros(n) if leans is None else leans
        self._sums = np.zeros((_ROWS, n))
        self.watch(np.zeros(n), np.zeros(n), np.zeros(n))

    def watch(self, error: Array, dq: Array, torque: Array) -> None:
        """Violation where pushing back drives a held joint away; (n,) rad from its place to the
        joint, rad/s, N·m sent."""
        axis = _look(
            error, dq, torque, self._least, self._leans, self._period, self._sums, LEFT, FAR, SURE,
            FEWEST, TAKES,
        )  # fmt: skip
        if axis >= 0:
            push = self._sums[_PUSH, axis] / max(self._sums[_TIME, axis], self._period)
            raise LoopFault(
                "wrong_sign",
                f"was pushed back by {abs(push):.2g} N·m on average and went away the faster, "
                f"{abs(error[axis]):.2g} rad by now: its torque acts the wrong way round",
                axis,
            )

    def restart(self) -> None:
        """Forget the past."""
        self._sums[:] = 0.0


@numba.njit(cache=True)
def _look(error, dq, torque, least, leans, period, sums, left, far, sure, fewest, takes):
    found = -1
    for j in range(len(error)):
        s = sums[:, j]
        near = abs(error[j]) < left
        if near or (abs(dq[j]) < BACK and s[_STOOD] == 1.0):
            s[:] = 0.0
            s[_FROM], s[_STOOD] = torque[j], 1.0
            continue
        if error[j] * dq[j] < 0.0 and abs(dq[j]) > BACK:
            s[_STOOD] = 0.0
        if s[_STOOD] == 0.0:
            continue
        for k in range(len(error)):
            if k != j and abs(dq[k]) > max(takes * abs(dq[j]), BACK):
                s[_STOOD] = 0.0
        if s[_STOOD] == 0.0:
            continue
        s[_TIME] += period
        s[_PUSH] += period * (torque[j] - s[_FROM])
        t, p, v = s[_TIME], s[_PUSH], dq[j]
        s[_TT] += t * t
        s[_TP] += t * p
        s[_PP] += p * p
        s[_TV] += t * v
        s[_PV] += p * v
        s[_VV] += v * v
        away = error[j] * v > 0.0 and error[j] * p < 0.0
        away = away and abs(torque[j] - s[_FROM]) > max(least[j], leans[j] * abs(error[j]))
        if abs(error[j]) < far or not away or t < fewest * period or found >= 0:
            continue
        room = s[_TT] * s[_PP] - s[_TP] * s[_TP]
        if room <= 1e-9 * s[_TT] * s[_PP]:
            continue
        c = (s[_TT] * s[_PV] - s[_TP] * s[_TV]) / room
        a = (s[_PP] * s[_TV] - s[_TP] * s[_PV]) / room
        rest = max(s[_VV] - a * s[_TV] - c * s[_PV], 0.0) / max(t / period - 2.0, 1.0)
        if c < 0.0 and c * c > sure * sure * rest * s[_TT] / room:
            found = j
    return found
