"""With which torques a joint has stood where it stands.

A servo that does not get on, against an obstacle or its own friction, presses ever harder: all of
those torques held the joint, and the last holds it least once the obstacle is gone. Of all of them
that one counts which is nearest to what is thought to be its weight.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SETTLED = 1e-3  # rad: a joint that moves further stands elsewhere; gears give way by about as much


class StoodWith:
    """Of n joints, since each moved last or ``restart``."""

    def __init__(self, n: int) -> None:
        self._at = np.full(n, np.nan)
        self._low, self._high = np.zeros(n), np.zeros(n)

    def restart(self) -> None:
        """Brakes hold the joints, or did until now: what is sent says nothing."""
        self._at[:] = np.nan

    def see(self, q: Array, sent: Array) -> None:
        """(n,) rad in this cycle, and N·m under which it came there."""
        new = ~(np.abs(q - self._at) <= SETTLED)
        self._at[new], self._low[new], self._high[new] = q[new], sent[new], sent[new]
        np.minimum(self._low, sent, out=self._low)
        np.maximum(self._high, sent, out=self._high)

    def nearest(self, thought: Array, sent: Array) -> Array:
        """(n,) N·m that held each joint, as near to ``thought`` as there were; ``sent`` for those
        that nobody has seen standing."""
        unseen = np.isnan(self._at)
        return np.where(unseen, sent, np.clip(thought, self._low, self._high))
