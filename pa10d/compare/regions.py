"""Ranges of a quantity in which a joint's squared error piles up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.compare.quantities import Quantity
from pa10d.compare.samples import Bins

Array = NDArray[np.float64]

DENSITY = 1.5  # a bin joins a region when its squared error is this many times the mean
SIZE_DENSITY = 1.2  # the same for the error's size, by which significance is judged
WIDEST = 0.6  # share of the samples above which it is no longer a region


@dataclass(frozen=True)
class Region:
    """low, high: range of the quantity; open_low, open_high: it reaches that end of what was
    visited; share: of the joint's squared error; samples: of its samples"""

    quantity: Quantity
    low: float
    high: float
    open_low: bool
    open_high: bool
    share: float
    samples: float

    @property
    def excess(self) -> float:
        """Share of squared error beyond the share of samples."""
        return self.share - self.samples

    def holds(self, x: Array) -> NDArray[np.bool_]:
        """(K,) which samples lie in it."""
        return (x >= self.low) & (x <= self.high)


def pile(table: Bins, size: Array) -> Array:
    """How far errors pile up: the largest share of Σ|e|, given per bin as ``size`` (B, S), that an
    interval of bins carries beyond SIZE_DENSITY times its share of the samples. (S,)

    The size and not its square, because the few largest errors would decide a square alone.
    """
    return np.max(_gains(table, size, SIZE_DENSITY), axis=(0, 1))


def find_region(table: Bins, square: Array) -> Region | None:
    """The interval of bins that carries most of Σe², given as square (B,), beyond DENSITY times
    its share of the samples."""
    gains = _gains(table, square[:, None], DENSITY)[..., 0]
    first, last = np.unravel_index(int(np.argmax(gains)), gains.shape)
    if gains[first, last] <= 0:
        return None
    inside = slice(int(first), int(last))
    return Region(
        quantity=table.quantity,
        low=float(table.edges[first]),
        high=float(table.edges[last]),
        open_low=first == 0,
        open_high=last == len(table.edges) - 1,
        share=float(square[inside].sum() / square.sum()),
        samples=float(table.count[inside].sum() / table.count.sum()),
    )


def _gains(table: Bins, sums: Array, density: float) -> Array:
    """(B+1, B+1, S) for intervals from edge i to edge j; 0 where that is none."""
    share = np.cumsum(np.vstack([np.zeros((1, sums.shape[1])), sums]), axis=0)
    share /= np.maximum(share[-1], 1e-300)
    width = np.concatenate([[0.0], np.cumsum(table.count)]) / table.count.sum()
    beyond = share - density * width[:, None]
    gains = beyond[None, :, :] - beyond[:, None, :]
    wide = width[None, :] - width[:, None]
    gains[(wide <= 0) | (wide > WIDEST)] = 0.0
    return gains
