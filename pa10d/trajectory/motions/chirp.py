"""A sine whose frequency rises, at an acceleration that the joint can follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.trajectory.motions.base import MotionState
from pa10d.trajectory.motions.entered import Entered

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Chirp(Entered):
    """q = centre + A(f)·sin φ(t), φ' = 2πf, f rising geometrically from ``low`` to ``high`` Hz.

    A falls with f so that amplitude rad, speed rad/s and acceleration rad/s², (n,) each, are never
    exceeded, to within the slow change of A: 1/A⁴ = 1/amplitude⁴ + (ω/speed)⁴ + (ω²/acceleration)⁴.
    A joint of amplitude 0 stands.
    """

    name = "chirp"

    centre: Array
    amplitude: Array
    speed: Array
    acceleration: Array
    low: float
    high: float

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.centre)

    def path(self, t: Array) -> MotionState:
        """Before 0 and after ``seconds`` the frequency stays."""
        growth = np.log(self.high / self.low) / self.seconds
        inside = np.clip(t, 0.0, self.seconds)
        omega = 2 * np.pi * self.low * np.exp(growth * inside)
        phase = (omega - 2 * np.pi * self.low) / growth + omega * (t - inside)
        moving = (t > 0) & (t < self.seconds)
        rate = np.where(moving, growth, 0.0)  # dω/dt = rate·ω
        size, slope, curve = self._size(omega[:, None])
        # chain rule along s = ln ω, ds/dt = rate
        size_dot, size_ddot = slope * rate[:, None], curve * rate[:, None] ** 2
        sine, cosine = np.sin(phase)[:, None], np.cos(phase)[:, None]
        w, w_dot = omega[:, None], (rate * omega)[:, None]
        dq = size_dot * sine + size * w * cosine
        ddq = size_ddot * sine + (2 * size_dot * w + size * w_dot) * cosine - size * w**2 * sine
        return self.centre + size * sine, dq, ddq

    def _size(self, w: Array) -> tuple[Array, Array, Array]:
        """A, dA/d ln ω, d²A/d ln ω²."""
        still = self.amplitude == 0
        terms = (
            np.where(still, 1.0, self.amplitude) ** -4.0 + 0 * w,
            (w / self.speed) ** 4,
            (w**2 / self.acceleration) ** 4,
        )
        total = terms[0] + terms[1] + terms[2]
        first, second = 4 * terms[1] + 8 * terms[2], 16 * terms[1] + 64 * terms[2]
        size = np.where(still, 0.0, total**-0.25)
        pull = first / total
        slope = -0.25 * size * pull
        curve = -0.25 * (slope * pull + size * (second / total - pull**2))
        return size, slope, curve
