"""One sine per joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.trajectory.motions.base import MotionState
from pa10d.trajectory.motions.entered import Entered

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sines(Entered):
    """centre + amplitude·sin(2π·frequency·t + phase), each (n,): rad, rad, Hz, rad."""

    name = "sines"

    centre: Array
    amplitude: Array
    frequency: Array
    phase: Array

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.centre)

    def path(self, t: Array) -> MotionState:
        """The sines, for ever."""
        omega = 2 * np.pi * self.frequency
        angle = np.outer(t, omega) + self.phase
        swing = self.amplitude * np.sin(angle)
        speed = self.amplitude * omega * np.cos(angle)
        return self.centre + swing, speed, -(omega**2) * swing
