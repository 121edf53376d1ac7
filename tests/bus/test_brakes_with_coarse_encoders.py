"""A brake holds its axis whatever the encoder on it is able to tell."""

from __future__ import annotations

import numpy as np
import pytest

from backends.virtual.drives.mechanics import Actuation, Mechanics

STRENGTH = 10.0  # N·m


class Leaning:
    """One joint that rubs a little and bears ``load`` N·m, with an encoder of so many bits."""

    def __init__(self, inertia, load, bits):
        self.inertia, self.load, self.count = inertia, load, 2.0 * np.pi / 2**bits
        self.q, self.dq = 1e-4, 0.0

    def measure(self):
        return np.round([self.q / self.count]) * self.count, np.zeros(1)

    def step(self, torque, dt):
        free = self.dq + dt * (torque[0] - self.load) / self.inertia
        rubs = dt * 0.03 * STRENGTH / self.inertia
        self.dq = np.sign(free) * max(abs(free) - rubs, 0.0)
        self.q += dt * self.dq


class Told(Leaning):
    """The same, and it says where it is."""

    def angles(self):
        return np.array([self.q])


@pytest.mark.parametrize(
    ("plant", "inertia", "bits"),
    [(Leaning, 0.1, 12), (Leaning, 0.02, 14), (Told, 0.003, 12), (Told, 0.1, 14)],
)
def test_a_closed_brake_holds_a_joint_whose_encoder_is_coarse(plant, inertia, bits):
    """A count in a quarter of a millisecond looked like 1.5 to 6 rad/s, and what brakes it slipped
    by that: a joint at rest ran through its closed brake at 1 to 19 rad/s."""
    leaning = plant(inertia, 0.7 * STRENGTH, bits)
    on, off, none = np.ones(1, bool), np.zeros(1, bool), np.zeros(1)
    count = np.array([leaning.count])
    mechanics = Mechanics(leaning, np.array([STRENGTH]), count=count)
    braked = Actuation(none, off, off, on, none, none, off, np.ones(1))
    for _ in range(80):
        mechanics.measure(off, 0.003)
        mechanics.advance(braked, 0.003)
    assert abs(leaning.q) < 0.01
