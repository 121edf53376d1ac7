"""Friction before sliding: bristles that bend (LuGre) or parallel springs that slip (Maxwell).

Canudas de Wit, Olsson, Åström, Lischinsky (1995); Al-Bender, Lampaert, Swevers (2005). The state
replaces the jump of dry friction at rest. Each substep takes the torque at its middle, linear in
the unknown velocity, so that stiff bristles cost no small steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from backends.virtual.plant.compiled import inner
from backends.virtual.plant.gather import of
from backends.virtual.plant.hidden import Hidden
from backends.virtual.plant.records import Array, Ints, Record
from pa10d.common.errors import UserError

LUGRE, MAXWELL = 1, 2
ELEMENTS = 8


class Bristles(NamedTuple):
    """bristles (n,) 0, LUGRE or MAXWELL; sigma0 N·m/rad, sigma1 N·m·s/rad (n,).

    share (n, ELEMENTS) of the friction level and slip displacement (n, ELEMENTS), rad.
    """

    bristles: Ints
    sigma0: Array
    sigma1: Array
    share: Array
    slip: Array


def bristles_of(effects: Sequence[Hidden], n: int) -> Bristles:
    """Pre-sliding parameters of the joints that have them."""
    kind, sigma0, sigma1 = np.zeros(n, np.int64), np.zeros(n), np.zeros(n)
    share, slip = np.zeros((n, ELEMENTS)), np.ones((n, ELEMENTS))
    for effect in of(effects, "presliding_hysteresis"):
        j, values = effect.joint, effect.values
        if values["model"] == "lugre":
            kind[j], sigma0[j], sigma1[j] = LUGRE, effect["sigma0"], effect["sigma1"]
            if sigma0[j] <= 0:
                raise UserError("presliding_hysteresis.sigma0: expected a stiffness above 0")
        elif values["model"] == "maxwell":
            shares, slips = values["shares"], values["displacements"]
            if len(shares) != len(slips) or not 0 < len(shares) <= ELEMENTS or min(slips) <= 0:
                raise UserError(
                    "presliding_hysteresis: shares and displacements must be as many, "
                    f"at most {ELEMENTS}, displacements above 0"
                )
            kind[j] = MAXWELL
            share[j, : len(shares)] = np.asarray(shares) / np.sum(shares)
            slip[j, : len(slips)] = slips
        else:
            found = values["model"]
            raise UserError(f"presliding_hysteresis.model: {found!r}, expected lugre or maxwell")
    return Bristles(kind, sigma0, sigma1, share, slip)


@inner
def resistance(joint: Record, z: Array, speed: float, top: float, h: float) -> tuple[float, float]:
    """(constant, slope): friction torque in mid-substep = constant + slope · velocity.

    z (ELEMENTS,) state, speed expected in mid-substep, top: friction level in steady sliding.
    """
    if joint.bristles == LUGRE:
        rate = joint.sigma0 * abs(speed) / max(top, 1e-9)
        kept = math.exp(-0.5 * rate * h)
        bent = (1.0 - kept) / rate if rate * h > 1e-9 else 0.5 * h
        constant = (joint.sigma0 - joint.sigma1 * rate) * kept * z[0]
        return constant, joint.sigma0 * bent + joint.sigma1 * kept
    constant = slope = 0.0
    for e in range(z.shape[0]):
        bound = joint.share[e] * top
        if bound == 0.0:
            continue
        stiffness = bound / joint.slip[e]
        trial = z[e] + 0.5 * h * stiffness * speed
        if abs(trial) < bound:
            constant += z[e]
            slope += 0.5 * h * stiffness
        else:
            constant += math.copysign(bound, trial)
    return constant, slope


@inner
def bend(joint: Record, z: Array, speed: float, top: float, h: float) -> None:
    """Carry the state over a substep that passed at this mean velocity."""
    if joint.bristles == LUGRE:
        rate = joint.sigma0 * abs(speed) / max(top, 1e-9)
        kept = math.exp(-rate * h)
        z[0] = z[0] * kept + speed * ((1.0 - kept) / rate if rate * h > 1e-9 else h)
        return
    for e in range(z.shape[0]):
        bound = joint.share[e] * top
        z[e] = min(max(z[e] + bound / joint.slip[e] * speed * h, -bound), bound)
