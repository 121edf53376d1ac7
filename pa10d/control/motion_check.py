"""Every row of a motion, looked at when it arrives: control trusts nobody who planned it.

One compiled pass, 10 ns a number: a minute at 500 Hz takes 10 ms, in which the arm is held.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.control.limits import ArmLimits
from pa10d.control.outside import ROUNDING, wrong_on_the_way_in

Array = NDArray[np.float64]

START_TOLERANCE = 2e-3  # rad between where the arm is held and where a motion begins
JUMP = 0.02  # of the speed limit, by which a step may differ from what the speeds say
CHANGE = 2.0  # of the acceleration limit, by which speeds may differ from one row to the next
CARRIED = 2.0  # of the torque limit, by which what a joint carries may differ from where it begins

_FINE, _NUMBER, _LOW, _HIGH, _FAST, _HARD, _STEP, _KICK, _TORQUE = range(9)
_SAYS = {
    _NUMBER: "holds {value}, expected a number",
    _LOW: "would stop at {value:.4g} rad, beyond its lower limit of {limit:.4g} rad",
    _HIGH: "would stop at {value:.4g} rad, beyond its upper limit of {limit:.4g} rad",
    _FAST: "moves at {value:.4g} rad/s, its limit is {limit:.4g} rad/s",
    _HARD: "accelerates with {value:.4g} rad/s², its limit is {limit:.4g} rad/s²",
    _STEP: "jumps by {value:.4g} rad from what its speed says, allowed are {limit:.4g} rad",
    _KICK: "changes its speed by {value:.4g} rad/s in one row, allowed are {limit:.4g} rad/s",
    _TORQUE: "brings {value:.4g} N·m along, allowed are {limit:.4g} N·m",
}


def wrong_with_rows(
    rows: Array, first: int, last: int, held: Array, limits: ArmLimits, period: float
) -> str | None:
    """rows (N, 4n) as ``MotionUnderWay`` has them, to begin at held (n,) rad → one line, or None.

    The line names joint, second, what was found and what is allowed. A joint that is held outside
    its limits may go from there inward, slowly.
    """
    n = len(held)
    if rows.ndim != 2 or rows.shape[1] != 4 * n or not len(rows) or rows.dtype != np.float64:
        return f"the motion is a table of {rows.shape} {rows.dtype}, expected (N, {4 * n}) float64"
    if not 0 <= first <= last <= len(rows):
        return f"it shall record rows {first} to {last} of {len(rows)}"
    seen = np.asarray(rows).view()
    seen.flags.writeable = False  # as rows in a file are: one compiled version serves all
    kind, row, joint, value, limit = _first_wrong(
        seen, n, period, np.where(held < limits.lower, -np.inf, limits.lower),
        np.where(held > limits.upper, np.inf, limits.upper), limits.velocity,
        limits.acceleration, limits.torque,
    )  # fmt: skip
    if kind != _FINE:
        says = _SAYS[kind].format(value=value, limit=limit)
        return f"joint {joint + 1} at {row * period:.3f} s (row {row}) {says}"
    slowest = CHANGE * limits.acceleration * period
    for end, word in ((0, "begins"), (-1, "ends")):
        for j in np.flatnonzero(np.abs(rows[end, n : 2 * n]) > slowest):
            speed = float(rows[end, n + j])
            return f"joint {j + 1}: the motion {word} at {speed:.4g} rad/s, expected at rest"
    away = np.abs(rows[0, :n] - held)
    if not (away < START_TOLERANCE).all():
        worst = int(np.argmax(away))
        return (
            f"the motion begins with joint {worst + 1} at {rows[0, worst]:.4f} rad, it is held at "
            f"{held[worst]:.4f}; plan again from where the arm is"
        )
    return wrong_on_the_way_in(seen, held, limits)


def compile_motion_check(limits: ArmLimits) -> None:
    """Now, and not while the arm is held."""
    n = len(limits.torque)
    wrong_with_rows(np.zeros((1, 4 * n)), 0, 1, np.zeros(n), limits, 1.0)


@numba.njit(cache=True)
def _first_wrong(rows, n, period, lower, upper, velocity, acceleration, torque):
    for k in range(len(rows)):
        row = rows[k]
        for j in range(n):
            q, dq, ddq, extra = row[j], row[n + j], row[2 * n + j], row[3 * n + j]
            for value in (q, dq, ddq, extra):
                if not np.isfinite(value):
                    return _NUMBER, k, j, value, 0.0
            if abs(dq) > velocity[j] * (1.0 + ROUNDING):
                return _FAST, k, j, dq, velocity[j]
            if abs(ddq) > acceleration[j] * (1.0 + ROUNDING):
                return _HARD, k, j, ddq, acceleration[j]
            stop = q + 0.5 * dq * abs(dq) / acceleration[j]
            if stop < lower[j] - ROUNDING:
                return _LOW, k, j, stop, lower[j]
            if stop > upper[j] + ROUNDING:
                return _HIGH, k, j, stop, upper[j]
            if abs(extra) > CARRIED * torque[j]:
                return _TORQUE, k, j, extra, CARRIED * torque[j]
            if k > 0:
                before, speed = rows[k - 1, j], rows[k - 1, n + j]
                off = q - before - 0.5 * (dq + speed) * period
                most = JUMP * velocity[j] * period + acceleration[j] * period * period
                if abs(off) > most:
                    return _STEP, k, j, off, most
                most = CHANGE * acceleration[j] * period
                if abs(dq - speed) > most * (1.0 + ROUNDING):
                    return _KICK, k, j, dq - speed, most
    return _FINE, 0, 0, 0.0, 0.0
