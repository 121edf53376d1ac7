"""A third-party backend: an arm that stands still. It shows all that a backend must have."""

from __future__ import annotations

import numpy as np

from backends.protocol import Array, Feedback
from pa10d.profile import Profile


class StillArm:
    switching = False  # whatever is begun is done at once

    def __init__(self, profile: Profile) -> None:
        self.n = len(profile.drives or [])
        self.period, self.realtime = 1.0 / profile.control.rate, False
        self.warnings: list[str] = []
        self._time = 0.0

    def open(self) -> None:
        self._time = 0.0

    def begin_enable(self) -> None: ...

    def read(self) -> Feedback:
        self._time += self.period
        still, fresh = np.zeros(self.n), np.zeros(self.n, np.int64)
        return Feedback(self._time, still.copy(), still, fresh.copy(), fresh)

    def write(self, torque: Array) -> None: ...

    def quick_stop(self) -> None: ...

    def begin_disable(self) -> None: ...

    def begin_reset(self) -> None: ...

    def close(self) -> None: ...


def open_backend(profile: Profile) -> StillArm:
    return StillArm(profile)
