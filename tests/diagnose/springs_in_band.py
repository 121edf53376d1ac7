"""Simulated arms with a series spring whose mode lies in the band of the motion.

Mode: of the joint's link on its spring, the motor held. Highest frequency: of the fastest Fourier
motion. Ratios of 0.5 to 3, damping ratios of 0.02 to 0.1, as stiff as gravity asks for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from hidden_arms import PROFILE, Arm, _robot, _sizes

from backends.virtual.datasets.figures import heavy
from backends.virtual.datasets.motions import Array, Course, random_fourier
from backends.virtual.datasets.robot import open_robot
from backends.virtual.datasets.runs import KINDS, LEAD_IN, gathering, motion_of
from backends.virtual.datasets.sets import truth_of
from backends.virtual.plant.plant import Plant, build
from backends.virtual.plant.servo import feed_forward, nominal, servo_for
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording
from pa10d.profile import Profile

SECONDS, RATE = 20.0, 250.0  # long and fine enough for names, and quick
REST = 40.0  # s before a recording begins: no link still swings
HANGS = 0.15  # rad under the joint's usual gravity: softer gears nobody builds
HARMONICS = 5


@dataclass(frozen=True)
class Spring:
    """joint from 1, K N·m/rad, D N·m·s/rad; highest: Hz of the motion; ratio: mode over that."""

    joint: int
    stiffness: float
    damping: float
    highest: float
    ratio: float

    @property
    def hidden(self) -> dict[str, Any]:
        """As the simulator takes it."""
        return {
            "effect": "joint_elasticity",
            "joint": self.joint,
            "K": self.stiffness,
            "D": self.damping,
        }


def drawn_spring(seed: int) -> Spring:
    """Joint, motion and mode at random."""
    rng, f = np.random.default_rng([seed, 16]), _sizes()
    while True:
        j = int(rng.choice(heavy(f)))
        highest, ratio = rng.uniform(1.0, 2.5), np.exp(rng.uniform(np.log(0.5), np.log(3.0)))
        stiffness = f.inertia[j] * (2.0 * np.pi * ratio * highest) ** 2
        damping = 2.0 * rng.uniform(0.02, 0.1) * np.sqrt(stiffness * f.inertia[j])
        if stiffness >= max(f.load[j] / HANGS, 2.0 * f.slope[j]):
            return Spring(j + 1, float(stiffness), float(damping), float(highest), float(ratio))


def spring_arm(seed: int, spring: Spring | None = None) -> tuple[Spring, Arm]:
    """The arm with a drawn spring, and its textbook model."""
    spring = spring or drawn_spring(seed)
    robot = open_robot(PROFILE)
    dynamics, runs = {"spread": 0.2, "seed": seed}, {}
    for kind in KINDS:
        number = sum(kind.encode())
        plant = build(
            robot,
            effects=[spring.hidden],
            noise="white",
            seed=1000 * seed + number,
            dynamics=dynamics,
        )
        motion = _motion(kind, np.random.default_rng([seed, number]), spring.highest)
        runs[kind] = _from_rest(kind, plant, robot, motion)
    truth = truth_of(seed, [spring.hidden], "white", plant, 0.2)
    model = identify([runs["train_a"], runs["train_b"]], _robot(), name="m0")
    return spring, Arm(runs, (spring.hidden,), truth, model, False)


def _motion(kind: str, rng: np.random.Generator, highest: float) -> Course:
    reach = _sizes().reach
    if kind == "train_a":
        return random_fourier(rng, reach, 1.25 * HARMONICS / highest)
    if kind == "valid_a":
        return random_fourier(rng, reach, HARMONICS / highest)
    return motion_of(kind, rng, reach, SECONDS)


def _from_rest(kind: str, plant: Plant, profile: Profile, motion: Course) -> Recording:
    """A recording that begins where the arm hangs still."""
    dt = 1.0 / RATE
    arm, book = nominal(profile)
    t = np.arange(round(-REST * RATE), round(SECONDS * RATE) + 1) * dt - LEAD_IN
    forward = feed_forward(arm, book, *gathering(motion, t + 0.5 * dt))
    q, dq, _ = gathering(motion, t)
    plant.reset(q[0] - plant.sensing.encoder_offset)
    soft = plant.physics.transmission.rotor >= plant.n
    servo = servo_for(arm, book, plant.measure()[0], dt, soft)
    log = plant.follow(servo, q, dq, forward, dt)
    torque: Array = 0.5 * (log.torque[:-1] + log.torque[1:])
    recorded = slice(round(REST * RATE), None)
    torque, angle = torque[recorded], log.q[:-1][recorded]
    return Recording(kind, np.arange(len(torque)) * dt, angle, torque)
