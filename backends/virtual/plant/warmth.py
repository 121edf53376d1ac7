"""A joint that warms: one thermal state per joint, and what it does to the friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from backends.virtual.plant.compiled import inner
from backends.virtual.plant.gather import of, per_joint
from backends.virtual.plant.hidden import Hidden
from backends.virtual.plant.records import Array, Ints, Record
from pa10d.common.errors import UserError

AMBIENT = 25.0  # °C


class Warmth(NamedTuple):
    """Per joint (n,). The state runs from 0 (ambient) to 1 (so many kelvin above it).

    time_constant s; loss: share of the friction lost at 1, of the Coulomb part coulomb_share of
    it; by_power 0/1: pulled towards friction power / heat_power instead of towards 1.
    """

    loss: Array
    coulomb_share: Array
    time_constant: Array
    by_power: Ints
    heat_power: Array
    kelvin: Array
    start: Array


def warmth_of(effects: Sequence[Hidden], n: int) -> Warmth:
    """Thermal parameters; joints without the effect keep their friction."""
    name = "thermal_friction"
    by_power = np.zeros(n, np.int64)
    for effect in of(effects, name):
        if effect.values["law"] not in ("time", "power"):
            found = effect.values["law"]
            raise UserError(f"{name}.law: found {found!r}, expected 'time' or 'power'")
        by_power[effect.joint] = effect.values["law"] == "power"
    return Warmth(
        loss=per_joint(effects, name, "loss", n),
        coulomb_share=per_joint(effects, name, "coulomb_share", n),
        time_constant=per_joint(effects, name, "T", n, math.inf),
        by_power=by_power,
        heat_power=per_joint(effects, name, "power", n, 1.0),
        kelvin=per_joint(effects, name, "rise", n),
        start=per_joint(effects, name, "start", n),
    )


@inner
def remaining(joint: Record, warm: float) -> tuple[float, float]:
    """Factors left of the viscous and of the Coulomb friction at this state."""
    lost = joint.loss * warm
    return max(1.0 - lost, 0.0), max(1.0 - joint.coulomb_share * lost, 0.0)


@inner
def warm_up(joint: Record, warm: float, friction_power: float, h: float) -> float:
    """The state h seconds later (exact for a constant heat source)."""
    target = friction_power / joint.heat_power if joint.by_power else 1.0
    return target + (warm - target) * math.exp(-h / joint.time_constant)


def celsius(warmth: Warmth, warm: Array) -> Array:
    """Temperatures, °C, (n,)."""
    return np.asarray(AMBIENT + warmth.kelvin * warm)
