"""Torque that stands at the end of what its channel shows: what it was is not known there.

A limit shows as one extreme value that returns again and again while the joint moves. A coarse
sensor dwells on its highest level, too, but then about as long on the one below.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.measurement.dull import dull
from pa10d.measurement.spans import spans
from pa10d.measurement.standstill import NEVER_MOVES

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MOVING = 0.02  # of the joint's fast speed
STAYS = 3  # samples: a limit holds on
FEWEST = 10  # samples that stay, of fewer nothing is said
DWELLS = 6  # times as long as on the level below
ROUNDED = 1e-9  # of the torque's range: resampled between two equal values


@dataclass(frozen=True)
class Limit:
    """One end of a torque's range that it stands at.

    level: N·m (N); largest: the upper end; at (N,): samples there; held: how many of them stay
    there while the joint moves
    """

    level: float
    largest: bool
    at: Flags
    held: int


def limits(q: Array, tau: Array) -> Iterator[Limit]:
    """q (N,) rad (m), tau (N,) N·m (N) of one joint."""
    span = float(np.ptp(tau)) if len(tau) else 0.0
    if span == 0.0:
        return
    moving = is_moving(q)
    for side in (1.0, -1.0):
        values = side * tau
        top = float(values.max())
        at = values >= top - ROUNDED * span
        below = values[~at]
        beside = int(np.sum(below >= below.max() - ROUNDED * span))
        stays = np.diff(spans(at & moving))
        held = int(stays[stays >= STAYS].sum())
        if held >= FEWEST and held > DWELLS * beside:
            yield Limit(side * top, side > 0, at, held)


def clipped(q: Array, tau: Array) -> Flags:
    """(N, n) True where joint i's torque stands at a limit, of q and tau (N, n); throughout where
    its channel mostly shows nothing."""
    out = np.zeros(tau.shape, dtype=bool)
    for j in range(tau.shape[1]):
        if shows_nothing(q[:, j], tau[:, j]):
            out[:, j] = True
            continue
        for limit in limits(q[:, j], tau[:, j]):
            out[:, j] |= limit.at
    return out


def shows_nothing(q: Array, tau: Array) -> bool:
    """Of q (N,) and tau (N,) of one joint: does it move, and its channel mostly shows one value? A
    channel with no other at all may be of a joint that nothing drives: that is known."""
    moves = len(q) > 0 and bool(np.ptp(q) > NEVER_MOVES)
    return moves and dull(tau, is_moving(q)) is not None


def is_moving(q: Array) -> Flags:
    """(N,) faster than creeping, judged over several samples because encoders are coarse."""
    reach = min(5, (len(q) - 1) // 2)
    span = np.abs(q[2 * reach :] - q[: len(q) - 2 * reach])
    fast = span > max(MOVING * float(np.quantile(span, 0.99)), 1e-12)
    return np.concatenate([fast[:1].repeat(reach), fast, fast[-1:].repeat(reach)])
