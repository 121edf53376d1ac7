"""Reference motions in pieces: point to point with pauses, sweeps at constant speeds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from backends.virtual.datasets.motions import Array, Reach, Sampled


@dataclass(frozen=True)
class Stretches:
    """Quintic or constant-speed pieces: joint-wise polynomials between ``times`` (pieces + 1,).

    coefficients (pieces, 6, n), rising powers of the time since the piece began; at rest outside.
    """

    times: Array
    coefficients: Array

    def sample(self, t: Array) -> Sampled:
        """q, dq, ddq at times t."""
        inside = np.clip(t, self.times[0], self.times[-1])
        piece = np.clip(
            np.searchsorted(self.times, inside, side="right") - 1, 0, len(self.times) - 2
        )
        x = (inside - self.times[piece])[:, None]
        c = np.moveaxis(self.coefficients[piece], 1, 0)
        q = sum(c[k] * x**k for k in range(6))
        dq = sum(k * c[k] * x ** (k - 1) for k in range(1, 6))
        ddq = sum(k * (k - 1) * c[k] * x ** (k - 2) for k in range(2, 6))
        return np.asarray(q), np.asarray(dq), np.asarray(ddq)


def random_points(rng: np.random.Generator, reach: Reach, duration: float) -> Stretches:
    """Quintic moves of all joints between random poses at 0.7 of the speed limits, with pauses."""
    here = reach.middle + 0.25 * reach.half * rng.uniform(-1, 1, len(reach.half))
    times, pieces = [0.0], []
    while times[-1] < duration:
        there = reach.middle + 0.63 * reach.half * rng.uniform(-1, 1, len(reach.half))
        span = there - here
        takes = float(np.max(1.875 * np.abs(span) / (0.7 * reach.speed)))
        pieces.append(quintic(here, span, takes))
        pieces.append(quintic(there, 0.0 * span, 1.0))
        times += [times[-1] + takes, times[-1] + takes + rng.uniform(0.3, 1.2)]
        here = there
    return Stretches(np.array(times), np.array(pieces))


def random_sweeps(rng: np.random.Generator, reach: Reach, duration: float) -> Stretches:
    """All joints to and fro at constant speeds from slow to 0.5 of the limit, smooth reversals."""
    n = len(reach.half)
    here = reach.middle + 0.3 * reach.half * rng.choice([-1.0, 1.0], n)
    side = np.sign(reach.middle - here)
    times, pieces = [0.0], []
    while times[-1] < duration:
        speed = reach.speed * 0.5 * 10 ** rng.uniform(-1.3, 0, n)
        fits = 0.6 * reach.half / speed
        takes = float(np.clip(np.min(fits), 1.0, 4.0))
        speed = np.minimum(speed, 0.6 * reach.half / takes)
        for share, part in ((0.15, _ramp), (0.7, _cruise), (0.15, _brake)):
            piece, here = part(here, side * speed, share * takes)
            pieces.append(piece)
            times.append(times[-1] + share * takes)
        side = np.where(
            np.abs(here - reach.middle) > 0.3 * reach.half, np.sign(reach.middle - here), -side
        )
    return Stretches(np.array(times), np.array(pieces))


def quintic(start: Array, span: Array, takes: float) -> Array:
    """Coefficients (6, n) of a rest-to-rest move."""
    zero = np.zeros_like(start)
    return np.array(
        [start, zero, zero, 10 * span / takes**3, -15 * span / takes**4, 6 * span / takes**5]
    )


def _ramp(start: Array, speed: Array, takes: float) -> tuple[Array, Array]:
    zero = np.zeros_like(start)
    piece = np.array([start, zero, zero, speed / takes**2, -0.5 * speed / takes**3, zero])
    return piece, start + 0.5 * speed * takes


def _cruise(start: Array, speed: Array, takes: float) -> tuple[Array, Array]:
    zero = np.zeros_like(start)
    return np.array([start, speed, zero, zero, zero, zero]), start + speed * takes


def _brake(start: Array, speed: Array, takes: float) -> tuple[Array, Array]:
    zero = np.zeros_like(start)
    piece = np.array([start, speed, zero, -speed / takes**2, 0.5 * speed / takes**3, zero])
    return piece, start + 0.5 * speed * takes
