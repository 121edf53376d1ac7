"""A third-party plant: one pendulum per joint, written without anything of the project's."""

from __future__ import annotations

from typing import Any

import numpy as np


class Pendulums:
    """Independent joints: inertia·q̈ = torque - gravity·sin(q) - viscous·q̇ - coulomb·tanh(q̇/v0)."""

    def __init__(self, n: int, inertia: Any, gravity: Any, noise: float, seed: int) -> None:
        self.n = n
        self.inertia = np.broadcast_to(np.asarray(inertia, float), (n,))
        self.gravity = np.broadcast_to(np.asarray(gravity, float), (n,))
        self.noise, self.seed = noise, seed
        self.reset(np.zeros(n))

    def reset(self, q0: Any) -> None:
        self.q, self.dq = np.array(q0, float), np.zeros(self.n)
        self.torque, self.heat = np.zeros(self.n), np.zeros(self.n)
        self.random = np.random.default_rng(self.seed)

    def step(self, torque: Any, dt: float) -> None:
        self.torque = np.array(torque, float)
        steps = max(1, round(dt / 0.0005))
        h = dt / steps
        for _ in range(steps):
            friction = 2.0 * self.dq + 3.0 * np.tanh(self.dq / 0.02)
            force = self.torque - self.gravity * np.sin(self.q) - friction
            self.dq = self.dq + h * force / self.inertia
            self.q = self.q + h * self.dq
            self.heat += h * np.abs(friction * self.dq)

    def measure(self) -> tuple[Any, Any]:
        return self.q.copy(), self.torque + self.noise * self.random.standard_normal(self.n)

    def temperature(self) -> Any:
        return 25.0 + 0.01 * self.heat


def build(
    profile: Any, inertia: Any = 1.0, gravity: Any = 20.0, noise: float = 0.0, seed: int = 0
) -> Pendulums:
    """The factory that a profile names."""
    return Pendulums(len(profile.drives), inertia, gravity, noise, seed)


class Unmeasured:
    """A plant that has no thermometer."""

    def __init__(self, inner: Pendulums) -> None:
        self.n, self.reset, self.step, self.measure = (
            inner.n,
            inner.reset,
            inner.step,
            inner.measure,
        )


def without_thermometer(profile: Any) -> Unmeasured:
    """The same arm, but one whose temperature nobody measures."""
    return Unmeasured(build(profile))
