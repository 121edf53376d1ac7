"""Torque noise of the current sensors: white, strong or coloured, the same for the same seed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from backends.virtual.plant.records import Array
from pa10d.common.errors import UserError

KINDS: dict[str, dict[str, float]] = {
    "none": {"white": 0.0, "slow": 0.0, "corner_hz": 1.0},
    "white": {"white": 1.0, "slow": 0.0, "corner_hz": 1.0},
    "strong": {"white": 4.0, "slow": 0.0, "corner_hz": 1.0},
    "coloured": {"white": 1.0, "slow": 1.5, "corner_hz": 2.0},
}


def white_level(effort: Array) -> Array:
    """Standard deviation of the white noise, N·m, of joints with this peak torque, (n,)."""
    return np.asarray(0.5 * (effort / 232.0) ** 0.7)


class Noise:
    """Draws (steps, n) of noise, N·m; ``slow`` is a first-order process below corner_hz."""

    def __init__(self, kind: str | Mapping[str, Any], level: Array, seed: int) -> None:
        given = dict(kind) if isinstance(kind, Mapping) else {"kind": kind}
        name = given.pop("kind", "white")
        if name not in KINDS or not set(given) <= set(KINDS["none"]):
            raise UserError(
                f"simulation.options.noise: found {kind!r}, expected one of {', '.join(KINDS)}, "
                f"or these keys: kind, {', '.join(KINDS['none'])}"
            )
        shape = {**KINDS[name], **given}
        self._white = level * float(shape["white"])
        self._slow = level * float(shape["slow"])
        self._corner = float(shape["corner_hz"])
        self._seed = seed
        self._runs = 0
        self.restart()

    def restart(self) -> None:
        """A fresh stream for the next run; the k-th run of a seed is always the same."""
        self._rng = np.random.default_rng([self._seed, self._runs])
        self._runs += 1
        self._state = self._rng.standard_normal(len(self._white))

    def draw(self, steps: int, dt: float) -> Array:
        """Noise of the next ``steps`` samples, dt seconds apart, (steps, n)."""
        n = len(self._white)
        normal = self._rng.standard_normal((steps, 2, n))
        kept = math.exp(-2.0 * math.pi * self._corner * dt)
        drive = math.sqrt(1.0 - kept * kept) * normal[:, 1]
        slow = np.empty_like(drive)
        for k, push in enumerate(drive):
            slow[k] = self._state = kept * self._state + push
        return np.asarray(self._white * normal[:, 0] + self._slow * slow)
