"""Plans run on a plant in this process, as the daemon runs them over the bus: in simulated time,
with the encoder's counts, the drives' per mille and the bus's cycle of delay."""

from __future__ import annotations

import numpy as np
from fake_backend import FakeBackend


class BusLike(FakeBackend):
    """What was written in this cycle acts from the next SYNC on, in whole per mille."""

    def __init__(self, plant, period, rated):
        super().__init__(plant, period)
        self._step = np.asarray(rated) / 1000.0
        self._waiting = np.zeros(self.n)

    def _cycle(self):
        waiting, self._waiting = self._waiting, np.round(self.torque / self._step) * self._step
        self.torque, kept = waiting, self.torque
        feedback = super()._cycle()
        self.torque = kept
        return feedback
