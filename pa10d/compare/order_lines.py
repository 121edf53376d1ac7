"""Lines in the order spectrum: how high noise reaches, and what stands above it for good."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.compare.angle_periodogram import TURNS, periodogram

Array = NDArray[np.float64]

ALARM = 0.01  # chance that noise makes any line
SLOW_BINS = 6  # bins of the angle whose mean error, per direction, is no ripple


def slow_part(q: Array, dq: Array, y: Array) -> Array:
    """(N,) what of y is a slow curve against angle in either direction of motion: unexplained
    gravity and friction would otherwise leak into every order."""
    out = np.zeros_like(y)
    for way in (dq > 0, dq <= 0):
        if int(way.sum()) < 4 * SLOW_BINS:
            continue
        edges = np.quantile(q[way], np.linspace(0, 1, SLOW_BINS + 1))
        index = np.clip(np.searchsorted(edges, q[way], side="right") - 1, 0, SLOW_BINS - 1)
        count = np.maximum(np.bincount(index, minlength=SLOW_BINS), 1)
        middle = np.bincount(index, q[way], SLOW_BINS) / count
        mean = np.bincount(index, y[way], SLOW_BINS) / count
        out[way] = np.interp(q[way], middle, mean)
    return out


def noise_bar(share: Array, window: int) -> Array:
    """What noise as strong as the neighbourhood's median passes anywhere with chance ALARM."""
    window = min(window, len(share)) | 1
    level = scipy.ndimage.median_filter(share, window, mode="reflect")
    return np.minimum(level / np.log(2) * np.log(len(share) / ALARM), 1.0)


def find_lines(
    q: Array,
    dq: Array,
    error: Array,
    order: Array,
    window: int,
    halves: NDArray[np.bool_],
    most: int,
) -> tuple[list[tuple[float, float]], Array]:
    """The strongest line, then the strongest of what is left without it, and so on: a line's
    side lobes are no lines. The slow part is taken anew each time, free of the lines found.
    Returns (order, amplitude) of each and (N,) what is left without them."""
    orders: list[float] = []
    ripple, phasors = np.zeros_like(error), np.empty(0, dtype=complex)
    slow = slow_part(q, dq, error)
    rest = error - slow
    while len(orders) < most:
        share, _ = periodogram(q, rest, order)
        bar = noise_bar(share, window)
        k = int(np.argmax(share / bar))
        if share[k] <= bar[k] or not _steady(q, rest, float(order[k]), halves):
            break
        orders.append(_refined(q, rest, float(order[k])))
        phasors = _phasors(q, error - slow, orders)
        ripple = sum((_wave(q, n, z) for n, z in zip(orders, phasors, strict=True)), 0.0 * q)
        slow = slow_part(q, dq, error - ripple)
        rest = error - ripple - slow
    found = [(n, float(abs(z))) for n, z in zip(orders, phasors, strict=True)]
    return sorted(found, key=lambda line: -line[1]), rest


def has_line(q: Array, dq: Array, torque: Array, error: Array, order: float) -> bool:
    """Does the measured torque have at least half of a line of the error, in phase?"""
    seen, line = (_phasors(q, y - slow_part(q, dq, y), [order])[0] for y in (torque, error))
    return bool((seen * np.conj(line)).real > 0.5 * abs(line) ** 2)


def _steady(q: Array, y: Array, order: float, half: NDArray[np.bool_]) -> bool:
    """Whether the line has one phase in both halves of the data: ripple is tied to the angle for
    good."""
    one, other = (_phasors(q[part], y[part], [order])[0] for part in (half, ~half))
    return bool((one * np.conj(other)).real > 0.5 * max(abs(one), abs(other)) ** 2)


def _refined(q: Array, y: Array, order: float) -> float:
    """The order between the scanned ones that takes most of y."""

    def left(n: float) -> float:
        return float(np.sum((y - _wave(q, n, _phasors(q, y, [n])[0])) ** 2))

    found = scipy.optimize.minimize_scalar(
        left,
        bounds=(order - 1 / TURNS, order + 1 / TURNS),
        method="bounded",
        options={"xatol": 1e-3},
    )
    return float(found.x)


def _phasors(q: Array, y: Array, orders: list[float]) -> NDArray[np.complex128]:
    """a + ib of a·cos(Nq) + b·sin(Nq) for each order, fitted together with a constant."""
    waves = [f(n * q) for n in orders for f in (np.cos, np.sin)]
    basis = np.column_stack([*waves, np.ones_like(q)])
    fit = np.linalg.solve(basis.T @ basis, basis.T @ y)
    return np.asarray(fit[:-1:2] + 1j * fit[1:-1:2])


def _wave(q: Array, order: float, phasor: complex) -> Array:
    return np.asarray(phasor.real * np.cos(order * q) + phasor.imag * np.sin(order * q))
