"""A plant that nobody of the project wrote: Pinocchio's forward dynamics and dry friction.

Friction is an impulse after each step, as far as it can stop the joint (time stepping), so that
the arm really sticks. On joint 4 a Stribeck bump is added, in a form of its own.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

SUBSTEP = 1e-3  # s
SWEEPS = 8


class ForeignPlant:
    def __init__(self, profile, bump: float = 4.0, speed: float = 0.1, noise: float = 1.0) -> None:
        self.model = pin.buildModelFromUrdf(str(profile.urdf))
        self.data = self.model.createData()
        self.n = self.model.nv
        effort = np.array(profile.limits.torque)
        self.rotor = 0.6 * (effort / 232.0) ** 1.75
        self.model.armature = self.rotor
        self.dry, self.wet = 7.0 * (effort / 232.0) ** 0.8, 9.0 * (effort / 232.0) ** 0.8
        self.bump = np.zeros(self.n)
        self.bump[3], self.speed = bump, speed
        self.level = noise * 0.2 * (effort / 232.0) ** 0.7
        self.rng = np.random.default_rng(4)
        self.reset(np.zeros(self.n))

    def reset(self, q0):
        self.q, self.v = np.array(q0, float), np.zeros(self.n)
        self.torque = np.zeros(self.n)

    def step(self, torque, dt):
        self.torque = np.asarray(torque)
        count = max(1, round(dt / SUBSTEP))
        h = dt / count
        for _ in range(count):
            pull = self.torque - self.wet * self.v
            free = self.v + h * pin.aba(self.model, self.data, self.q, self.v, pull)
            level = self.dry + self.bump * np.exp(-np.abs(free) / self.speed)
            self.v = self.stuck(free, h * level)
            self.q = self.q + h * self.v

    def stuck(self, free, most):
        """Speeds after dry friction, whose impulse stops a joint or is ``most``; on one joint it
        is felt by all, so the joints are gone through until they agree."""
        mass = np.triu(pin.crba(self.model, self.data, self.q))
        give = np.linalg.inv(mass + np.triu(mass, 1).T)
        impulse, speed = np.zeros(self.n), np.array(free)
        for _ in range(SWEEPS):
            for j in range(self.n):
                wanted = np.clip(impulse[j] - speed[j] / give[j, j], -most[j], most[j])
                speed += give[:, j] * (wanted - impulse[j])
                impulse[j] = wanted
        return speed

    def measure(self):
        return self.q.copy(), self.torque + self.level * self.rng.standard_normal(self.n)


def make(profile, **options):
    """The factory that a profile names."""
    return ForeignPlant(profile, **options)
