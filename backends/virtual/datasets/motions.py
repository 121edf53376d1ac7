"""Reference motions for test data: Fourier series and slow sines.

A motion is sampled at any times t (N,) into q, dq, ddq (N, n). All are drawn at random within a
share of the position and velocity limits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Sampled = tuple[Array, Array, Array]


@dataclass(frozen=True)
class Reach:
    """Limits per joint: lower, upper rad, speed rad/s, each (n,)."""

    lower: Array
    upper: Array
    speed: Array

    @property
    def middle(self) -> Array:
        """Centre of the range."""
        return 0.5 * (self.lower + self.upper)

    @property
    def half(self) -> Array:
        """Half of the range."""
        return 0.5 * (self.upper - self.lower)


class Course(Protocol):
    """Anything that can be sampled."""

    def sample(self, t: Array) -> Sampled:
        """q, dq, ddq at times t."""
        ...


@dataclass(frozen=True)
class Fourier:
    """centre + Σ a_k sin(kωt) + b_k cos(kωt); a, b (harmonics, n)."""

    omega: float
    centre: Array
    a: Array
    b: Array

    def sample(self, t: Array) -> Sampled:
        """q, dq, ddq at times t."""
        k = self.omega * np.arange(1, len(self.a) + 1)
        s, c = np.sin(np.outer(t, k)), np.cos(np.outer(t, k))
        q = self.centre + s @ self.a + c @ self.b
        dq = (c * k) @ self.a - (s * k) @ self.b
        return q, dq, -(s * k**2) @ self.a - (c * k**2) @ self.b


@dataclass(frozen=True)
class Sines:
    """One sine per joint, frequencies apart: centre + amplitude·sin(ωt + phase), each (n,)."""

    centre: Array
    amplitude: Array
    omega: Array
    phase: Array

    def sample(self, t: Array) -> Sampled:
        """q, dq, ddq at times t."""
        angle = np.outer(t, self.omega) + self.phase
        swing = self.amplitude * np.sin(angle)
        return (
            self.centre + swing,
            self.amplitude * self.omega * np.cos(angle),
            -(self.omega**2) * swing,
        )


def random_fourier(rng: np.random.Generator, reach: Reach, period: float) -> Fourier:
    """Five harmonics that start at rest, as fast as 0.75 of the limits allow."""
    n, orders = len(reach.half), np.arange(1, 6)
    a, b = rng.normal(size=(2, 5, n))
    a -= np.outer(orders, orders @ a) / (orders @ orders)  # no speed at t = 0
    b -= np.outer(orders**2, orders**2 @ b) / np.sum(orders**4)  # no acceleration at t = 0
    omega = 2.0 * np.pi / period
    centre = reach.middle + 0.1 * reach.half * rng.uniform(-1, 1, n)
    q, dq, _ = Fourier(omega, np.zeros(n), a, b).sample(np.linspace(0, period, 801))
    room = 0.75 * reach.half - np.abs(centre - reach.middle)
    scale = np.minimum(0.75 * reach.speed / np.abs(dq).max(0), room / np.abs(q).max(0))
    return Fourier(omega, centre, a * scale, b * scale)


def random_sines(rng: np.random.Generator, reach: Reach) -> Sines:
    """Slow sines over a third of the range at 0.04 to 0.08 Hz."""
    n = len(reach.half)
    omega = 2.0 * np.pi * rng.uniform(0.04, 0.08, n)
    amplitude = np.minimum(0.36 * reach.half, 0.75 * reach.speed / omega)
    return Sines(reach.middle, amplitude, omega, rng.uniform(0, 2 * np.pi, n))
