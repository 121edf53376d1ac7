"""Does a torque act the wrong way round? Seen in the small steps that a first motion begins with,
one joint at a time.

Friction held the joint until then. It goes the other way than it is asked to, the faster the more
it is pushed; one that moves may take others along, of which nothing is said. Speed since it left
its place is v0 + a·t + c·∫(u - u0)dt: least squares, a few sums. Under u0 it was held where it
began; what it weighs is other as others lean, and a is what was lacking. Where all that its weight
may have changed by since then outweighs u - u0, it may as well lean over, however slowly.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.control.faults import LoopFault
from pa10d.control.reference import Reference

Array = NDArray[np.float64]

LEFT, FAR = 1e-3, 0.01  # rad: where it begins, and what is enough to judge
NEAR = 0.05  # rad, further than which no place of a first step is
CREEPS = 0.02  # rad/s, slower than which friction may be all that there is to see
PUSHED = 0.02  # of the torque limit, less than which moves no other joint
STANDS = 0.1  # of the way of a joint, by which another that it shakes may give and yet stand
SURE = 6.0  # standard errors
FEWEST = 8  # cycles
_ROWS = 9
_COUNT, _P, _PP, _V, _VP, _VV, _T, _TP, _VT = range(_ROWS)


class FirstSteps:
    """Sums of every joint since it left its place, and where all stood then."""

    def __init__(self, strongest: Array, period: float, leans: Array | None = None) -> None:
        """strongest: (n,) N·m, the torque limits; leans: (n,) N·m/rad, of which the smaller one is
        what a joint's weight changes by at most as another turns, None: nothing."""
        n = len(strongest)
        self._period, self._least = period, PUSHED * strongest
        self._leans = np.zeros(n) if leans is None else leans
        self._sums = np.zeros((_ROWS, n))
        self._left_at = np.zeros((n, n))  # rad, of all joints, as each left its place
        self._passed = np.zeros(n)  # N·m·s by which each was pushed until now
        self._side = np.zeros(n)  # of its place on which each is
        self._way = np.zeros(n)  # in which each was asked to move last
        self._stood = np.zeros((2, n))  # rad where each should be, and N·m that held it there
        self._begun = False
        nowhere = np.zeros(n)
        self._judged(nowhere, nowhere, nowhere, nowhere)  # compiled before it counts

    def watch(self, q: Array, dq: Array, torque: Array, reference: Reference) -> None:
        """Violation where torque moves a joint the wrong way; (n,) rad, rad/s, N·m sent."""
        led = reference.dq != 0.0
        if not self._begun and not led.any():
            self._stood[:] = reference.q, torque
            return
        self._begun = True
        self._way[led] = np.sign(reference.dq[led])
        if np.abs(reference.q - self._stood[0]).max() > NEAR:
            return
        axis = self._judged(q, dq, torque, reference.q)
        if axis < 0:
            return
        push, far = torque - self._stood[1], abs(q[axis] - reference.q[axis])
        raise LoopFault(
            "wrong_sign",
            f"was pushed by {push[axis]:.2g} N·m and went the other way, the faster, {far:.2g} "
            "rad by now: its torque acts the wrong way round",
            axis,
        )

    def restart(self) -> None:
        """Forget the past."""
        self._sums[:] = 0.0
        self._passed[:] = self._side[:] = self._way[:] = 0.0
        self._begun = False

    def _judged(self, q: Array, dq: Array, torque: Array, wanted: Array) -> int:
        found: int = _look(
            q, dq, torque - self._stood[1], q - wanted, q - self._stood[0], self._way, self._least,
            self._leans, self._period, self._passed, self._side, self._left_at, self._sums,
        )  # fmt: skip
        return found


@numba.njit(cache=True)
def _look(q, dq, push, error, went, way, least, leans, period, passed, sides, left_at, sums):
    passed += period * push
    for i in range(len(q)):
        side = np.sign(error[i])
        if abs(error[i]) < LEFT or abs(dq[i]) < CREEPS or side != sides[i]:
            sums[:, i] = 0.0
            left_at[i] = q
            sides[i] = side
            continue
        s = sums[:, i]
        s[_COUNT] += 1.0
        s[_P] += passed[i]
        s[_PP] += passed[i] * passed[i]
        s[_V] += dq[i]
        s[_VP] += dq[i] * passed[i]
        s[_VV] += dq[i] * dq[i]
        t = s[_COUNT] * period
        s[_T] += t
        s[_TP] += t * passed[i]
        s[_VT] += t * dq[i]
    for i in range(len(q)):
        moved = q - left_at[i]
        against = push[i] * error[i] < 0.0 and way[i] * error[i] < 0.0
        away = error[i] * dq[i] > 0.0 and error[i] * moved[i] > 0.0
        if not (away and against) or min(abs(error[i]), abs(moved[i])) < FAR:
            continue
        if abs(push[i]) <= (np.minimum(leans, leans[i]) * np.abs(went)).sum():
            continue
        if sums[_COUNT, i] < FEWEST or _slope(sums[:, i], period) >= 0.0:
            continue
        give = LEFT + STANDS * abs(moved[i])
        taken = False  # along by another joint
        for k in range(len(q)):
            pushed = abs(push[k]) >= least[k] and push[k] * moved[k] > 0.0
            taken = taken or (k != i and pushed and abs(moved[k]) > give)
        if not taken:
            return i
    return -1


@numba.njit(cache=True)
def _slope(s, period):
    """rad/s per N·m·s of these sums, 0 where it is not sure."""
    count = s[_COUNT]
    pp = s[_PP] - s[_P] * s[_P] / count
    vp, vv = s[_VP] - s[_V] * s[_P] / count, s[_VV] - s[_V] * s[_V] / count
    tt = period * period * count * (count * count - 1.0) / 12.0
    tp, vt = s[_TP] - s[_T] * s[_P] / count, s[_VT] - s[_V] * s[_T] / count
    own = pp - tp * tp / tt  # what is no straight rise
    if own <= 1e-6 * s[_PP]:
        return 0.0
    c = (vp - vt * tp / tt) / own
    rest = max(vv - vt * vt / tt - c * c * own, 0.0)
    return c if c * c * own * (count - 3.0) > SURE * SURE * rest else 0.0
