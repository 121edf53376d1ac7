"""Where the arm stood when it was at rest and unpowered, for the control process that comes next.

While the arm is powered nothing is kept: what ended then left it wherever it came to rest.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pa10d.daemon.robot.for_the_next import ForTheNext
from pa10d.profile import Profile

Array = NDArray[np.float64]

MOVED = 1e-3  # rad (m), by which it is written anew
PATIENCE = 2.0  # s for a disk; the arm is powered all the same
STILL = 0.01  # rad/s (m/s)


class StoodAt:
    """``known``: rad (m), one a joint, or None."""

    def __init__(self, profile: Profile, data: Path) -> None:
        self._n = len(profile.drives or [])
        self._file = ForTheNext(
            profile, data, "stood",
            "where the arm stands is not kept", "where the arm stood is kept, though it moves",
        )  # fmt: skip
        self._leaving = False
        self.known: list[float] | None = self._read()

    def becomes(self, profile: Profile) -> None:
        """The profile is another one now: of other drives or zeros nothing is known."""
        if self._file.becomes(profile):
            self.known = None

    def note(self, q: Array, dq: Array) -> None:
        """It stands at q (n,), unpowered, every drive answers."""
        if self._leaving or self._file.busy or np.abs(dq).max() > STILL:
            return
        if self.known is not None and np.abs(q - np.array(self.known)).max() < MOVED:
            return
        self.known = [float(value) for value in q]
        self._file.keep(self.known)

    async def forget(self) -> None:
        """It is about to be powered."""
        self._leaving, self.known = True, None
        try:
            self._file.remove()
            if self._file.work is not None:
                await asyncio.wait([self._file.work], timeout=PATIENCE)
        finally:
            self._leaving = False

    def close(self) -> None:
        """What is being written is written to its end."""
        self._file.close()

    def _read(self) -> list[float] | None:
        with contextlib.suppress(ValueError, TypeError):
            values = [float(value) for value in self._file.read() or []]
            if values and len(values) == self._n and all(map(math.isfinite, values)):
                return values
        return None
