"""Where has each joint been? What a joint passed freely on its way does not bar its way back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CLEARLY = 0.1  # of the following error that is allowed: more than play and noise of an encoder


class Places:
    """The lowest and highest position of every joint since power-up; (n,) rad each."""

    def __init__(self, following_error: Array) -> None:
        self._clearly = CLEARLY * following_error
        self._low, self._high = np.zeros_like(following_error), np.zeros_like(following_error)

    def restart(self, q: Array) -> None:
        """The arm was powered up at q."""
        self._low[:] = self._high[:] = q

    def see(self, q: Array) -> None:
        """It is at q now."""
        np.minimum(self._low, q, out=self._low)
        np.maximum(self._high, q, out=self._high)

    def towards(self, wanted: Array, q: Array, axis: int) -> bool:
        """Whether a joint at q that should go to ``wanted`` has been further that way."""
        up = wanted[axis] > q[axis]
        beyond = self._high[axis] - q[axis] if up else q[axis] - self._low[axis]
        return bool(beyond > self._clearly[axis])
