"""What a drive or a driver does to the torque that it reports: a low-pass of one parameter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FIRST_ORDER, SECOND_ORDER, MEAN = "first order", "second order", "mean"
DELAYS = {FIRST_ORDER: 1.0, SECOND_ORDER: float(np.sqrt(2.0)), MEAN: 0.5}
"""kind -> how late it makes a slow signal, in units of its own time."""


@dataclass(frozen=True)
class TorqueFilter:
    """A low-pass that the torque channel has passed before it was recorded.

    kind: "first order" with time constant ``seconds``, "second order" (Butterworth) with corner
    at 1/(2π·seconds) Hz, or "mean" over ``seconds``
    """

    kind: str
    seconds: float

    @property
    def delay(self) -> float:
        """s by which slow signals come out late."""
        return DELAYS[self.kind] * self.seconds

    def gain(self, frequency: Array) -> NDArray[np.complex128]:
        """Complex gain at ``frequency`` Hz beside that delay: timing is told by itself."""
        turn = 2.0 * np.pi * np.asarray(frequency, dtype=np.float64) * self.seconds
        if self.kind == MEAN:
            return np.asarray(np.sinc(turn / (2.0 * np.pi)), dtype=np.complex128)
        if self.kind == FIRST_ORDER:
            passed = 1.0 / (1.0 + 1j * turn)
        else:
            passed = 1.0 / (1.0 + np.sqrt(2.0) * 1j * turn - turn**2)
        return np.asarray(passed * np.exp(1j * DELAYS[self.kind] * turn), dtype=np.complex128)

    def __str__(self) -> str:
        return self.give_or_take(0.0)

    def give_or_take(self, share: float) -> str:
        """In words; share: what its time is unsure by, as a part of it (0, infinite: untold)."""
        mean = self.kind == MEAN
        size = 1e3 * self.seconds if mean else 0.5 / np.pi / self.seconds
        error = f" ± {share * size:.2g}" if 0.0 < share < np.inf else ""
        if mean:
            return f"a mean over {size:.3g}{error} ms"
        return f"a low-pass of {self.kind} at {size:.3g}{error} Hz"
