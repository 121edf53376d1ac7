"""Between rotor and link: rigid, a spring, or a gap with springs at its ends.

A joint whose transmission gives has two coordinates: the rotor's (where the encoder sits) and the
link's. Spong, Modeling and control of elastic joint robots (1987).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from backends.virtual.plant.compiled import inner
from backends.virtual.plant.gather import per_joint
from backends.virtual.plant.hidden import Hidden
from backends.virtual.plant.records import Array, Ints, Record
from pa10d.common.errors import UserError


class Transmission(NamedTuple):
    """rotor (n,): index of the coordinate that carries the rotor, the link's own if rigid.

    inertia (n,) rotor inertia, kg·m² at the joint side; stiffness N·m/rad, damping N·m·s/rad and
    half gap rad, (n,), used where rotor[j] ≠ j.
    """

    rotor: Ints
    inertia: Array
    stiffness: Array
    damping: Array
    gap: Array


def transmission_of(effects: Sequence[Hidden], inertia: Array) -> Transmission:
    """Series compliance and backlash of the joints that have them."""
    n = len(inertia)
    spring = per_joint(effects, "joint_elasticity", "K", n)
    teeth = per_joint(effects, "backlash", "K", n)
    damping = per_joint(effects, "joint_elasticity", "D", n)
    damping += per_joint(effects, "backlash", "D", n)
    gives = (spring > 0) | (teeth > 0)
    if np.any(gives & (inertia <= 0)):
        raise UserError("joint_elasticity and backlash need a rotor_inertia above 0 on their joint")
    with np.errstate(divide="ignore"):
        in_series = 1.0 / (
            1.0 / np.where(spring > 0, spring, np.inf) + 1.0 / np.maximum(teeth, 1e-300)
        )
    stiffness = np.where(teeth > 0, np.where(spring > 0, in_series, teeth), spring)
    rotor = np.arange(n)
    rotor[gives] = n + np.arange(int(gives.sum()))
    gap = per_joint(effects, "backlash", "b", n)
    return Transmission(rotor.astype(np.int64), inertia, stiffness, damping, gap)


@inner
def transmitted(joint: Record, twist: float, rate: float) -> tuple[float, float]:
    """(spring torque, damping coefficient) passed from rotor to link at this twist and its rate."""
    wound = twist
    if joint.gap > 0.0:
        if twist > joint.gap:
            wound = twist - joint.gap
        elif twist < -joint.gap:
            wound = twist + joint.gap
        else:
            return 0.0, 0.0
        # teeth push, they do not pull
        if (joint.stiffness * wound + joint.damping * rate) * wound < 0.0:
            return 0.0, 0.0
    return joint.stiffness * wound, joint.damping
