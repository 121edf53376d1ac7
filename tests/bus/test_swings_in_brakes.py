"""A link on its gear swings on behind a closed brake, until it rests."""

from __future__ import annotations

import numpy as np
import pytest

from backends.virtual.drives.mechanics import LONGEST, Actuation, Mechanics

STIFF, ROTOR, LINK, COUNT = 800.0, 0.2, 1.3, 1.2e-5  # N·m/rad, kg·m², kg·m², rad


class OnItsGear:
    """One joint: a rotor with an encoder, and a link on a spring that loses 3 % of critical."""

    def __init__(self):
        self.rotor, self.link, self.spin, self.speed = 0.0, 0.04, 0.0, 0.0

    def measure(self):
        return np.round([self.rotor / COUNT]) * COUNT, np.zeros(1)

    def step(self, torque, dt):
        bent, damping = self.link - self.rotor, 0.06 * np.sqrt(STIFF * LINK)
        pull = STIFF * bent + damping * (self.speed - self.spin)
        self.speed -= dt * pull / LINK
        self.spin += dt * (torque[0] + pull) / ROTOR
        self.link, self.rotor = self.link + dt * self.speed, self.rotor + dt * self.spin


def test_an_arm_is_taken_as_rigid_once_no_link_swings_in_its_brake():
    plant, on, off = OnItsGear(), np.ones(1, bool), np.zeros(1, bool)
    mechanics, none = Mechanics(plant, np.array([62.0])), np.zeros(1)
    braked = Actuation(none, off, off, on, none, none, off, np.ones(1))
    powered = Actuation(none, on, off, on, none, none, off, np.ones(1))
    mechanics.advance(powered, 0.005)  # what it does next is watched
    passed, before = 0.0, None
    while plant.speed != before:
        before, passed = plant.speed, passed + 0.005
        mechanics.measure(off, 0.005)
        mechanics.advance(braked, 0.005)
    swings = STIFF * np.hypot(plant.link - plant.rotor, plant.speed / np.sqrt(STIFF / LINK))
    assert swings < 0.02 * 62.0
    assert passed < LONGEST


class Lift:
    """One slide that rubs nowhere."""

    def __init__(self, mass):
        self.mass, self.q, self.dq = mass, 0.0, 0.0

    def measure(self):
        return np.array([self.q]), np.zeros(1)

    def step(self, torque, dt):
        self.dq += dt * (torque[0] / self.mass - 9.81)
        self.q += dt * self.dq


@pytest.mark.parametrize("mass", [0.3, 28.0])
def test_a_slide_hardly_gives_way_to_its_weight_in_its_brake(mass):
    """3 mm at 0.13 m/s, as if a metre were a radian: it was told to come out of its closed brake,
    and to fall where it did not."""
    plant, on, off = Lift(mass), np.ones(1, bool), np.zeros(1, bool)
    mechanics, none = Mechanics(plant, np.array([14.0 * mass]), on), np.zeros(1)
    powered = Actuation(none, on, off, on, none, none, off, np.ones(1))
    lowest, fastest = 0.0, 0.0
    for _ in range(200):
        mechanics.measure(on, 0.003)
        mechanics.advance(powered, 0.003)
        lowest, fastest = min(lowest, plant.q), max(fastest, abs(plant.dq))
    assert lowest > -8e-4
    assert fastest < 0.07
    assert abs(plant.dq) < 1e-6
