"""The joint servo that makes the simulated arm follow a motion: PD with nominal feed-forward.

It knows the URDF and the default friction, not the arm's own masses, friction or hidden effects.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from backends.virtual.plant.arm import Arm, arm_of_model, base_gravity
from backends.virtual.plant.assemble import arm_model
from backends.virtual.plant.compiled import entry
from backends.virtual.plant.inertia import mass_matrix
from backends.virtual.plant.records import Array, Table
from backends.virtual.plant.rigid import bias, frames, place
from backends.virtual.plant.run import Servo
from backends.virtual.plant.state import bodies_of
from backends.virtual.plant.textbook import Textbook, default_textbook, peak_torques
from pa10d.profile import Profile

Bools = NDArray[np.bool_]

BANDWIDTH = 2.0 * math.pi * 8.0  # rad/s, closed loop
VELOCITY_FILTER = 2.0 * math.pi * 40.0  # rad/s, on the encoder's difference
SOFT_SPEED_LOOP = 2.0 * math.pi * 25.0  # rad/s, with the rotor alone, where the link hangs loose
SOFT_RATIO = 2.0 * math.pi * 2.5  # 1/s, kp / kd there
REVERSAL_SPEED = 0.02  # rad/s over which the friction feed-forward changes sides


def nominal(profile: Profile) -> tuple[Arm, Textbook]:
    """What a control engineer would take the arm for: URDF masses and default drive figures."""
    model = arm_model(profile)
    return arm_of_model(model, base_gravity(profile)), default_textbook(
        peak_torques(model, profile)
    )


def servo_for(arm: Arm, book: Textbook, q0: Array, dt: float, soft: Bools) -> Servo:
    """Critically damped gains for the nominal inertia in pose q0; the memory starts there.

    soft (n,): joints found springy or loose when tuned, with gains that the rotor alone bears.
    """
    inertia = inertia_at(arm, book, q0)
    smoothing = 1.0 - math.exp(-VELOCITY_FILTER * dt)
    n = len(q0)
    kd = np.where(soft, book.rotor_inertia * SOFT_SPEED_LOOP, 2.0 * inertia * BANDWIDTH)
    kp = np.where(soft, kd * SOFT_RATIO, inertia * BANDWIDTH**2)
    return Servo(kp, kd, 1.5 * book.effort, smoothing, np.array(q0, float), np.zeros(n))


def inertia_at(arm: Arm, book: Textbook, q0: Array) -> Array:
    """Diagonal of the mass matrix with rotors in pose q0, (n,)."""
    mass = np.zeros((len(q0), len(q0)))
    _mass(bodies_of(arm), np.asarray(q0, float), frames(len(q0)), mass)
    return np.diag(mass) + book.rotor_inertia


def feed_forward(arm: Arm, book: Textbook, q: Array, dq: Array, ddq: Array) -> Array:
    """Nominal torque along a motion, all (steps, n): rigid bodies, rotors, smoothed friction."""
    n = q.shape[1]
    out = np.empty_like(q)
    _rigid_torque(bodies_of(arm), arm.gravity, q, dq, ddq, frames(n), np.zeros((n, n)), out)
    rubbing = book.coulomb * np.tanh(dq / REVERSAL_SPEED) + book.viscous * dq
    return np.asarray(out + book.rotor_inertia * ddq + rubbing)


@entry
def _mass(bodies: Table, q: Array, work: Table, out: Array) -> None:
    place(bodies, q, work)
    mass_matrix(bodies, work, out)


@entry
def _rigid_torque(
    bodies: Table,
    gravity: Array,
    q: Array,
    dq: Array,
    ddq: Array,
    work: Table,
    mass: Array,
    out: Array,
) -> None:
    for k in range(q.shape[0]):
        place(bodies, q[k], work)
        bias(bodies, gravity, dq[k], work, out[k])
        mass_matrix(bodies, work, mass)
        for i in range(q.shape[1]):
            for j in range(q.shape[1]):
                out[k, i] += mass[i, j] * ddq[k, j]
