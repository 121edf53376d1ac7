"""What the compiled step works on: the fixed figures of an arm, its state, scratch memory."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from backends.virtual.plant.arm import Arm
from backends.virtual.plant.bristles import ELEMENTS, Bristles
from backends.virtual.plant.friction import Friction
from backends.virtual.plant.records import Array, Table, blank, table
from backends.virtual.plant.rigid import frames
from backends.virtual.plant.sensing import Sensing
from backends.virtual.plant.transmission import Transmission
from backends.virtual.plant.warmth import Warmth


class Physics(NamedTuple):
    """Everything that is fixed about one simulated arm, mechanism by mechanism."""

    arm: Arm
    friction: Friction
    warmth: Warmth
    bristles: Bristles
    transmission: Transmission
    extras: Table

    @property
    def size(self) -> int:
        """Number of coordinates N: links, then the rotors that turn apart from their links."""
        return max(len(self.transmission.rotor), int(np.max(self.transmission.rotor)) + 1)


class Figures(NamedTuple):
    """The same for compiled code: records per body and per joint (n,), extra effects (m,)."""

    bodies: Table
    gravity: Array
    joints: Table
    extras: Table


class Bodies(NamedTuple):
    """The part of an Arm that is per joint."""

    parent: Array
    prismatic: Array
    axis: Array
    rotation: Array
    offset: Array
    mass: Array
    com: Array
    inertia: Array


class PlantState(NamedTuple):
    """q, v, acc (N,): coordinates and their rates; impulse (n + m,) N·m·s of dry friction;

    bent (n, ELEMENTS) bristles; warm (n,); stretch (m,) rad of forgetting springs; load, rubbing
    (n,): N·m transmitted to the links and lost to friction; outside (n,) N·m against the links'
    motion, by laws of other packages.
    """

    q: Array
    v: Array
    acc: Array
    impulse: Array
    bent: Array
    warm: Array
    stretch: Array
    load: Array
    rubbing: Array
    outside: Array


class Scratch(NamedTuple):
    """What a substep writes and forgets: records per joint, vectors (N,), matrices (N, N)."""

    frames: Table
    joints: Table
    q: Array
    v: Array
    force: Array
    bias: Array
    after: Array
    mass: Array
    damping: Array
    inverse: Array


def figures_of(physics: Physics, sensing: Sensing) -> Figures:
    """Pack an arm and its sensors for compiled code."""
    p = physics
    joints = table(p.friction, p.warmth, p.bristles, p.transmission, sensing)
    return Figures(bodies_of(p.arm), p.arm.gravity, joints, p.extras)


def bodies_of(arm: Arm) -> Table:
    """(n,) records of the links."""
    return table(Bodies(*(getattr(arm, name) for name in Bodies._fields)))


def new_state(physics: Physics, q0: Array) -> PlantState:
    """At rest in pose q0 (n,), cold, bristles straight."""
    n, m, size = len(q0), len(physics.extras), physics.size
    q = np.zeros(size)
    q[:n] = q0
    q[physics.transmission.rotor] = q0
    still, bent = np.zeros(size), np.zeros((n, ELEMENTS))
    warm, impulse = physics.warmth.start.copy(), np.zeros(n + m)
    return PlantState(
        q, still, still.copy(), impulse, bent, warm, np.zeros(m), np.zeros(n), np.zeros(n),
        np.zeros(n),
    )  # fmt: skip


def new_scratch(physics: Physics) -> Scratch:
    """Scratch memory of the right sizes.

    Of each joint: bounds of dry friction without load, whether it sticks, the torque that enters
    the rotor by all but dry friction and transmission, what drags it in proportion to speed,
    bristle torque at rest, friction level in sliding.
    """
    n, size = len(physics.transmission.rotor), physics.size
    names = ("forward", "backward", "sticks", "entering", "drag", "constant", "top")
    joints = blank(n, **{name: () for name in names})
    shapes = 5 * [(size,)] + 3 * [(size, size)]
    return Scratch._make([frames(n), joints, *(np.zeros(shape) for shape in shapes)])
