"""Fourier series, equation 13 of the paper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.trajectory.fourier import fourier_basis
from pa10d.trajectory.motions.base import MotionState
from pa10d.trajectory.motions.entered import Entered

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Fourier(Entered):
    """q_i = centre_i + Σ_l a_li sin(ωlt) - b_li cos(ωlt), ω = 2π·fundamental.

    centre (n,) rad; a, b (harmonics, n) rad; fundamental Hz
    """

    name = "fourier"

    fundamental: float
    centre: Array
    a: Array
    b: Array

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.centre)

    @property
    def period(self) -> float:
        """s."""
        return 1.0 / self.fundamental

    def path(self, t: Array) -> MotionState:
        """The series, for ever."""
        b0, b1, b2 = fourier_basis(self.fundamental, len(self.a), t)
        x = np.vstack([self.centre, self.a, self.b])
        return b0 @ x, b1 @ x, b2 @ x
