"""A third-party backend: an arm that stands still. It shows all that a backend must have."""

from __future__ import annotations

import numpy as np

from backends.protocol import Array, Feedback, Hold
from pa10d.profile import Profile


class StillArm:
    def __init__(self, profile: Profile) -> None:
        self.n = len(profile.drives or [])
        self.period, self.realtime = 1.0 / profile.control.rate, False
        self.warnings: list[str] = []
        self._time = 0.0

    def open(self) -> None:
        self._time = 0.0

    def enable(self, hold: Hold | None = None) -> None: ...

    def read(self) -> Feedback:
        self._time += self.period
        still, fresh = np.zeros(self.n), np.zeros(self.n, np.int64)
        return Feedback(self._time, still.copy(), still, fresh.copy(), fresh)

    def write(self, torque: Array) -> None: ...

    def quick_stop(self) -> None: ...

    def disable(self) -> None: ...

    def reset(self) -> None: ...

    def close(self) -> None: ...


def open_backend(profile: Profile) -> StillArm:
    return StillArm(profile)
