"""A long signal that is looked at again and again: any stretch of it at once, no peak lost."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pa10d.figures.decimate import extremes

BLOCK = 256  # samples whose extremes are found once


class Pyramid:
    """The signal, and the extremes of every ``BLOCK`` of its samples in their order."""

    def __init__(self, signal: ArrayLike) -> None:
        """signal: (N,), nan where nothing is known."""
        self.fine = np.ascontiguousarray(signal, dtype=np.float32)
        blocks = max(1, math.ceil(len(self.fine) / BLOCK))
        self.coarse, self._step = extremes(self.fine, 2 * blocks)

    def stretch(self, first: int, last: int, points: int) -> tuple[NDArray[Any], float, float]:
        """Samples first … last-1 in at most about ``points`` values; with them where the first one
        lies and how far each is from the next, in samples."""
        if last - first < points * BLOCK:
            values, step = extremes(self.fine[first:last], points)
            return values, float(first), step
        begin = int(first / self._step) // 2 * 2
        values, step = extremes(self.coarse[begin : math.ceil(last / self._step)], points)
        return values, begin * self._step, step * self._step
