"""Dry and viscous friction of a joint: how large it can be, not yet which way it points.

A dry friction torque is set-valued at rest. ``level`` gives its bound at a velocity and state;
the direction, and the value while the joint sticks, are found by stiction.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from backends.virtual.plant.compiled import inner
from backends.virtual.plant.gather import per_joint
from backends.virtual.plant.hidden import Hidden
from backends.virtual.plant.records import Array, Record
from pa10d.common.errors import UserError


class Friction(NamedTuple):
    """Per joint (n,), N·m and N·m·s/rad.

    coulomb, viscous ± their splits for positive and negative velocity; a Stribeck rise;
    power_gain·|q̇|^power; mu·|transmitted torque|, mu ± dmu by who drives whom; a bump and a wave
    of the level against q.
    """

    coulomb: Array
    viscous: Array
    coulomb_split: Array
    viscous_split: Array
    rise: Array
    rise_speed: Array
    rise_power: Array
    power_gain: Array
    power: Array
    mu: Array
    dmu: Array
    bump: Array
    bump_centre: Array
    bump_width: Array
    wave: Array
    wave_cycles: Array
    wave_phase: Array


def friction_of(effects: Sequence[Hidden], coulomb: Array, viscous: Array) -> Friction:
    """Collect everything that shapes the friction level of the joints."""
    n = len(coulomb)

    def get(name: str, key: str, absent: float = 0.0) -> Array:
        return per_joint(effects, name, key, n, absent)

    mu, dmu = get("load_friction", "mu"), get("load_friction", "dmu")
    if np.any(np.abs(dmu) > mu):
        raise UserError("load_friction.dmu: expected no more than mu, else friction would drive")
    return Friction(
        coulomb=coulomb,
        viscous=viscous,
        coulomb_split=get("coulomb_asymmetry", "dFc"),
        viscous_split=get("coulomb_asymmetry", "dFv"),
        rise=get("stribeck", "Fs"),
        rise_speed=get("stribeck", "vs", 1.0),
        rise_power=get("stribeck", "delta", 1.0),
        power_gain=get("nonlinear_viscous", "Fp"),
        power=get("nonlinear_viscous", "p", 1.0),
        mu=mu,
        dmu=dmu,
        bump=get("position_friction", "height"),
        bump_centre=get("position_friction", "centre"),
        bump_width=get("position_friction", "width", 1.0),
        wave=get("position_friction", "wave"),
        wave_cycles=get("position_friction", "cycles"),
        wave_phase=get("position_friction", "phase"),
    )


@inner
def level(
    joint: Record, q: float, added: float, speed: float, cooled: float, direction: float
) -> float:
    """Largest dry friction torque against motion in ``direction`` (±1) at no load, N·m.

    added: what other joints add to it, N·m; cooled: what warmth has left of the Coulomb part.
    """
    out = joint.coulomb + direction * joint.coulomb_split + added
    if joint.bump != 0.0:
        x = (q - joint.bump_centre) / joint.bump_width
        out += joint.bump * math.exp(-0.5 * x * x)
    if joint.wave != 0.0:
        out += joint.wave * math.sin(joint.wave_cycles * q + joint.wave_phase)
    out *= cooled
    if joint.rise != 0.0:
        out += joint.rise * math.exp(-((abs(speed) / joint.rise_speed) ** joint.rise_power))
    return max(out, 0.0)


@inner
def viscous(joint: Record, speed: float, thinned: float) -> float:
    """Viscous coefficient, N·m·s/rad, with the power law taken as a secant; thinned by warmth."""
    out = joint.viscous
    if speed > 0.0:
        out += joint.viscous_split
    elif speed < 0.0:
        out -= joint.viscous_split
    out *= thinned
    if joint.power_gain != 0.0:
        out += joint.power_gain * abs(speed) ** (joint.power - 1.0)
    return out
