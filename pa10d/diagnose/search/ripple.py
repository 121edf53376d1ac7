"""Torque ripple in the spectrum of the residual against angle: where to start looking, and how
easily noise alone has such a line somewhere."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    HIGHEST_OF_SLIDES,
    HIGHEST_ORDER,
    LEAST_TURNS,
    LINES_WORK,
    LOWEST_ORDER,
    ORDERS_PER_RESOLUTION,
    RIPPLE_LEAST_SPAN,
)
from pa10d.diagnose.regression.side import Side
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]


def order_peaks(
    side: Side, residual: PerJoint, joint: int, count: int = 3, below: float = np.inf
) -> list[float]:
    """Orders N (cycles per revolution) of the strongest lines of the residual against q_j.

    The power of residual·exp(-iNq), each sample weighted with what the low-pass leaves of a line
    at its momentary frequency N·|q̇|/2π, over a grid as fine as the range of q resolves.
    """
    q, v, r = _along(side, residual, joint)
    if float(np.ptp(q)) < RIPPLE_LEAST_SPAN:
        return []
    lowpass = side.runs[0].lowpass
    power = 2 * lowpass.order
    slowness = (v / (2 * np.pi * lowpass.cutoff)) ** power
    lowest, highest = _looked_through(side, joint, q)
    highest = min(highest, below)
    if highest <= lowest:
        return []
    first = slice(0, _affordable(q, highest - lowest))
    orders = np.arange(lowest, highest, _fineness(q[first]))
    found = _strongest(_lines(q[first], slowness[first], r[first], orders, power), count)
    if first.stop == len(q):
        return [float(orders[i]) for i in found]
    return [_closer(q, slowness, r, orders[i], _fineness(q[first]), power) for i in found]


def shaken_orders(side: Side, joint: int, count: int = 3) -> list[float]:
    """Orders at which a joint that goes round is shaken most, within the band. What ripples shakes
    it, and at one speed inertia and viscous friction take that line whole: hardly any of it is left
    to be seen."""
    shaken = [run.filtered(run.context.ddq[:, joint], joint) for run in side.runs]
    swing = {joint: side.gathered(shaken, joint)}
    q, v, _ = _along(side, swing, joint)
    if side.contexts[0].robot.prismatic[joint] or not len(q) or float(np.ptp(q)) < 2.0 * np.pi:
        return []
    within = 2.0 * np.pi * side.runs[0].lowpass.cutoff / max(float(np.median(v)), 1e-9)
    return order_peaks(side, swing, joint, count, within)


def _looked_through(side: Side, joint: int, q: Array) -> tuple[float, float]:
    """From which order to which: cycles per revolution, of a slide rad/m."""
    if not side.contexts[0].robot.prismatic[joint]:
        return LOWEST_ORDER, HIGHEST_ORDER
    return 2.0 * np.pi * LEAST_TURNS / float(np.ptp(q)), HIGHEST_OF_SLIDES


def _fineness(q: Array) -> float:
    """Cycles per revolution between orders that are looked at, of angles (m,)."""
    return float(np.pi / np.ptp(q) / ORDERS_PER_RESOLUTION)


def _affordable(q: Array, orders: float) -> int:
    """How many of these angles, from the first on: one that turns on and on has as many orders to
    look at as turns."""
    span = np.maximum.accumulate(q) - np.minimum.accumulate(q)
    work = span * np.arange(1, len(q) + 1) * orders
    within = int(np.searchsorted(work, LINES_WORK * np.pi / ORDERS_PER_RESOLUTION, side="right"))
    return max(2, within)


def _strongest(score: Array, count: int) -> list[int]:
    peaks = np.flatnonzero((score[1:-1] >= score[:-2]) & (score[1:-1] >= score[2:])) + 1
    return [int(i) for i in peaks[np.argsort(score[peaks])[::-1][:count]]]


def _closer(
    q: Array, slowness: Array, r: Array, order: float, known_to: float, power: int
) -> float:
    """Of all angles, what was found in some of them."""
    reach = ORDERS_PER_RESOLUTION * known_to
    orders = np.arange(order - reach, order + reach, _fineness(q))
    return float(orders[int(np.argmax(_lines(q, slowness, r, orders, power)))])


def chance_of_line(side: Side, joint: int, power: float) -> float:
    """Probability that noise alone has a line of at least this power at any order looked through.

    power: of the strongest line, χ² of two where its order is given beforehand. An order is no
    parameter like others: with every cycle over the range of q it is a new attempt. Upper bound
    for large power after Baluev, Mon. Not. R. Astron. Soc. 385 (2008), eq. 6:
    e^(-z)·(1 + W·√z), z half the power, W = range of orders in cycles per rad · √(4π·var q).
    """
    q = [run.context.q[:: run.lowpass.factor, joint] for run in side.runs]
    seen = side.gathered(q, joint)
    lowest, highest = _looked_through(side, joint, seen)
    attempts = (highest - lowest) / (2 * np.pi) * np.sqrt(4 * np.pi * np.var(seen))
    z = 0.5 * power
    return float(min(1.0, np.exp(-z) * (1.0 + attempts * np.sqrt(z))))


def chance_beside_neighbours(
    side: Side, residual: PerJoint, joint: int, order: float, change: Array | None = None
) -> float:
    """Probability that the spectrum of a residual against q_j has a line as strong as the one at
    ``order`` by chance, when it is as strong as it is around it.

    Against the level of its own neighbourhood, since a residual of slow motion is no white noise
    against the angle: ordinates of a smooth spectrum are exponential, their mean is the median
    over ln 2. An order is known to a resolution of 2π over the range of q; the line is the
    strongest within it, and neighbours are farther away than that on both sides. Of a line that the
    model absorbs the residual shows the little that is left: so its ordinate is that along change
    (m_j,), what the line makes of the residual once the model is fitted anew, where that is more.
    """
    q, v, r = _along(side, residual, joint)
    span = float(np.ptp(q)) if len(q) else 0.0
    if span < RIPPLE_LEAST_SPAN:
        return 1.0
    step = 2.0 * np.pi / span / ORDERS_PER_RESOLUTION
    reach = int(np.clip(order / step / 4.0, 6 * ORDERS_PER_RESOLUTION, 40 * ORDERS_PER_RESOLUTION))
    offsets = np.arange(-reach, reach + 1)
    orders = order + step * offsets
    lowpass = side.runs[0].lowpass
    power = 2 * lowpass.order
    kept = orders > 0.5 * LOWEST_ORDER
    orders, offsets = orders[kept], offsets[kept]
    score = _lines(q, (v / (2 * np.pi * lowpass.cutoff)) ** power, r, orders, power)
    own = np.abs(offsets) <= ORDERS_PER_RESOLUTION
    level = float(np.median(score[np.abs(offsets) > 2 * ORDERS_PER_RESOLUTION])) / np.log(2.0)
    most = float(score[own].max())
    if change is not None and np.any(change):
        most = max(most, 0.5 * float(r @ change) ** 2 / float(change @ change))
    return float(min(1.0, 2.0 * np.exp(-most / max(level, 1e-300))))


def _along(side: Side, residual: PerJoint, joint: int) -> tuple[Array, Array, Array]:
    """Angle (rad), speed (rad/s) and residual (N·m) of the samples that count."""
    angle = [run.context.q[:: run.lowpass.factor, joint] for run in side.runs]
    speed = [run.context.dq[:: run.lowpass.factor, joint] for run in side.runs]
    q, v = (side.gathered(parts, joint) for parts in (angle, speed))
    return q, np.abs(v), residual[joint]


@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "nsz", "contract"})
def _lines(q, slowness, r, orders, power):
    """|Σ g·r·exp(-iNq)|² / Σ g² at equally spaced orders N, g = 1 / (1 + N^power · slowness).

    Each order's phases are those of the one before, turned on by one step.
    """
    m, step = len(q), orders[1] - orders[0]
    real, imaginary = np.cos(orders[0] * q), np.sin(orders[0] * q)
    turn_real, turn_imaginary = np.cos(step * q), np.sin(step * q)
    out = np.empty(len(orders))
    for k in range(len(orders)):
        steep, a, b, total = orders[k] ** power, 0.0, 0.0, 0.0
        for i in range(m):
            gain = 1.0 / (1.0 + steep * slowness[i])
            a += gain * r[i] * real[i]
            b += gain * r[i] * imaginary[i]
            total += gain * gain
            turned = real[i] * turn_real[i] - imaginary[i] * turn_imaginary[i]
            imaginary[i] = imaginary[i] * turn_real[i] + real[i] * turn_imaginary[i]
            real[i] = turned
        out[k] = (a * a + b * b) / max(total, 1e-12)
    return out
