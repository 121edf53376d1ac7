"""How the joints moved: what a warning needs to say which motion would have told more."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.piece import Piece

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MotionExtent:
    """Per joint (n,): lowest and highest angle (rad), fast speed (rad/s) and acceleration
    (rad/s²) as 99 % quantiles, number of reversals, seconds in motion; hidden: its torque is known
    nowhere."""

    low: Array
    high: Array
    speed: Array
    acceleration: Array
    reversals: NDArray[np.int64]
    seconds: Array
    hidden: NDArray[np.bool_]

    @property
    def range(self) -> Array:
        """(n,) rad."""
        return self.high - self.low


def excitation(pieces: Iterable[Piece]) -> MotionExtent:
    """Seen over all pieces."""
    low, high, speed, pace, turns, seconds = [], [], [], [], [], []
    hidden = []
    for piece in pieces:
        c, run = piece.context, piece.equation
        low.append(c.q.min(axis=0))
        high.append(c.q.max(axis=0))
        coarse = slice(None, None, max(1, run.lowpass.factor))
        speed.append(np.quantile(np.abs(c.dq[coarse]), 0.99, axis=0))
        pace.append(np.quantile(np.abs(run.lowpass(c.ddq)), 0.99, axis=0))
        way = np.where(np.abs(c.dq) > 0.02 * piece.fast, np.sign(c.dq), 0.0)
        turns.append([_changes(way[:, j]) for j in range(way.shape[1])])
        seconds.append(piece.moving.sum(axis=0) / run.rate)
        hidden.append(run.hidden)
    return MotionExtent(
        np.min(low, axis=0),
        np.max(high, axis=0),
        np.max(speed, axis=0),
        np.max(pace, axis=0),
        np.sum(turns, axis=0).astype(np.int64),
        np.sum(seconds, axis=0),
        np.all(hidden, axis=0),
    )


def _changes(direction: Array) -> int:
    moving = direction[direction != 0]
    return int(np.count_nonzero(np.diff(moving)))
