"""Quantities that a residual may depend on, under the names that a diagnosis calls them by.

``q4``, ``dq4``, ``ddq4`` (rad, rad/s, rad/s²), ``q4 0.4 s ago`` (what a lag remembers of the
angle), ``load4`` (N·m that the gear passes on), ``temperature4`` (°C), ``moving4`` (s since the
joint last stood), ``t`` (s since the start of the run). Joints are numbered from 1.
"""

from __future__ import annotations

import re

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.words import from_one
from pa10d.effects.context import Context
from pa10d.measurement.standstill import since_rest

Array = NDArray[np.float64]

NAME = re.compile(r"(q|dq|ddq|load|temperature|moving)(\d*)(?: (\d+(?:\.\d+)?) s ago)?|(t)")
UNITS = {
    "q": "rad", "dq": "rad/s", "ddq": "rad/s²", "load": "N·m", "temperature": "°C", "moving": "s",
    "t": "s",
}  # fmt: skip
KNOWN = "q, dq, ddq, load, temperature or moving of a joint (q4), 'q4 0.4 s ago', or t"
LONG_GONE = 2.0  # s after which a joint no longer knows that it stood
SMOOTH_HZ = 12.0  # of a measured acceleration: what differentiating twice adds is above


def parsed(name: str) -> tuple[str, int, float]:
    """(quantity, joint 0-based or -1 where none is named, seconds ago)."""
    match = NAME.fullmatch(name.strip())
    if match is None or (match[3] and match[1] != "q") or match[2] == "0":
        raise UserError(f"{name!r}: no quantity of a motion; expected {KNOWN}")
    if match[4]:
        return "t", -1, 0.0
    return match[1], int(match[2]) - 1 if match[2] else -1, float(match[3] or 0.0)


def unit_of(name: str) -> str:
    """Of a named quantity."""
    return UNITS[parsed(name)[0]]


def at_joint(name: str, joint: int, n: int) -> str:
    """The full name: ``q`` on its own is that of ``joint`` (0-based), of ``n`` there are."""
    quantity, named, seconds = parsed(name)
    if quantity == "t":
        return quantity
    if named >= n:
        raise UserError(f"{name!r}: expected joint {from_one(n)}")
    lag = f" {seconds:g} s ago" if seconds else ""
    return f"{quantity}{(joint if named < 0 else named) + 1}{lag}"


def values_of(context: Context, name: str) -> Array:
    """(N,) at the raw rate."""
    quantity, joint, seconds = parsed(name)
    if quantity == "t":
        return context.t
    if quantity == "moving":
        return since_it_stood(context.dq[:, joint], context.dt)
    if quantity == "temperature" and context.temperature is None:
        raise UserError(f"{name}: these runs have no temperature; expected columns temp1 …")
    values = np.asarray(getattr(context, quantity))[:, joint]
    if quantity == "ddq" and not context.desired:
        return _smooth(values, context.dt)
    return remembered(values, seconds, context.dt) if seconds else values


def since_it_stood(dq: Array, dt: float) -> Array:
    """(N,) s since a joint of speed (N,) last stood, no more than LONG_GONE."""
    return np.minimum(since_rest(dq, 1.0 / dt), LONG_GONE)


def remembered(q: Array, seconds: float, dt: float) -> Array:
    """(N,) q as a first-order lag with this time constant remembers it."""
    share = 1.0 - np.exp(-dt / seconds)
    start = np.array([(1.0 - share) * q[0]])
    return np.asarray(scipy.signal.lfilter([share], [1.0, share - 1.0], q, zi=start)[0])


def _smooth(values: Array, dt: float) -> Array:
    relative = SMOOTH_HZ * 2.0 * dt
    if relative >= 0.8 or len(values) < 20:
        return values
    return np.asarray(
        scipy.signal.sosfiltfilt(scipy.signal.butter(2, relative, output="sos"), values)
    )
