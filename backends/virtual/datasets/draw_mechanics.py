"""Springs, gaps, masses and stops of a size that shows, and what no library lists."""

from __future__ import annotations

import math

import numpy as np

from backends.virtual.datasets.figures import (
    Draw,
    Figures,
    Rng,
    another,
    any_joint,
    heavy,
    neighbours,
    sign,
)
from pa10d.common.jsonable import JsonObject


def _ripple(rng: Rng, f: Figures) -> JsonObject:
    j, angle = any_joint(rng, f), rng.uniform(0, 2 * math.pi)
    size = rng.uniform(0.15, 0.4) * f.book.coulomb[j]
    cycles = float(rng.choice([25, 50, 100, int(rng.integers(12, 120))]))
    return {
        "joint": j + 1,
        "N": cycles,
        "sin": size * math.sin(angle),
        "cos": size * math.cos(angle),
    }


def _elastic(rng: Rng, f: Figures) -> JsonObject:
    j = int(rng.choice(heavy(f)))
    stiffness = f.inertia[j] * (2 * math.pi * rng.uniform(1.8, 3.5)) ** 2
    damping = 2 * rng.uniform(0.03, 0.12) * math.sqrt(stiffness * f.inertia[j])
    return {"joint": j + 1, "K": stiffness, "D": damping}


def _gap(rng: Rng, f: Figures) -> JsonObject:
    j = int(rng.choice(heavy(f)))
    stiffness = f.inertia[j] * (2 * math.pi * rng.uniform(15.0, 25.0)) ** 2
    damping = 2 * rng.uniform(0.1, 0.3) * math.sqrt(stiffness * f.book.rotor_inertia[j])
    return {"joint": j + 1, "b": rng.uniform(0.006, 0.02), "K": stiffness, "D": damping}


def _spring(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f)
    k = rng.uniform(1.0, 2.5) * f.book.coulomb[j] / f.reach.half[j]
    return {"joint": j + 1, "k": k, "q0": f.reach.middle[j] + rng.uniform(-0.4, 0.4)}


def _payload(rng: Rng, f: Figures) -> JsonObject:
    mass = rng.uniform(0.8, 3.5) * float(np.max(f.book.effort)) / 232.0
    size = 0.05
    own = mass * size**2 * 0.4
    return {
        "mass": mass,
        "cx": rng.uniform(-0.05, 0.05),
        "cy": rng.uniform(-0.05, 0.05),
        "cz": rng.uniform(0.03, 0.15),
        "inertia": [float(f"{own:.3g}")] * 3 + [0.0] * 3,
    }


def _tilt(rng: Rng, f: Figures) -> JsonObject:
    size, angle = rng.uniform(0.015, 0.05), rng.uniform(0, 2 * math.pi)
    return {"x": size * math.cos(angle), "y": size * math.sin(angle)}


def _shared_mass(rng: Rng, f: Figures) -> JsonObject:
    # not the first joint's: products of inertia imitate a coupling to it in all but wide motion
    i, j = neighbours(rng, f, first=1)
    whole = f.lightest + f.book.rotor_inertia
    size = math.sqrt(whole[i] * whole[j])
    return {"joints": [i + 1, j + 1], "Ia": sign(rng) * rng.uniform(0.35, 0.6) * size}


def _stop(rng: Rng, f: Figures) -> JsonObject:
    j, side = any_joint(rng, f), sign(rng)
    angle = f.reach.middle[j] + side * rng.uniform(0.12, 0.25) * f.reach.half[j]
    k = rng.uniform(0.5, 1.5) * f.book.coulomb[j] / (0.1 * f.reach.half[j])
    return {"joint": j + 1, "k": k, "qs": angle, "side": side}


def _cable(rng: Rng, f: Figures) -> JsonObject:
    i = any_joint(rng, f)
    j = another(rng, f, i)
    size = rng.uniform(0.5, 1.2) * f.book.coulomb[i]
    return {"joints": [i + 1, j + 1], "amplitude": size, "phase": rng.uniform(0, 1.0)}


def _fan(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f)
    top = (0.6 * f.reach.speed[j]) ** 2 * 0.3 * f.reach.half[j]
    return {"joint": j + 1, "drag": rng.uniform(0.5, 1.2) * f.book.coulomb[j] / top}


def _magnet(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f)
    return {
        "joint": j + 1,
        "pull": rng.uniform(0.4, 0.9) * f.book.coulomb[j],
        "centre": f.reach.middle[j] + rng.uniform(-0.2, 0.2) * f.reach.half[j],
        "width": rng.uniform(0.06, 0.12) * f.reach.half[j],
    }


def _creep(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f)
    k = rng.uniform(1.0, 2.5) * f.book.coulomb[j] / (0.4 * f.reach.half[j])
    return {"joint": j + 1, "k": k, "T": rng.uniform(0.5, 3.0)}


def _wheel(rng: Rng, f: Figures) -> JsonObject:
    i = any_joint(rng, f)
    j = another(rng, f, i)
    top = 0.25 * f.reach.speed[i] * f.reach.speed[j]
    return {"joints": [i + 1, j + 1], "amplitude": rng.uniform(0.5, 1.2) * f.book.coulomb[i] / top}


MECHANICS: dict[str, Draw] = {
    "torque_ripple": _ripple,
    "joint_elasticity": _elastic,
    "backlash": _gap,
    "spring": _spring,
    "payload": _payload,
    "base_tilt": _tilt,
    "coupling_inertia": _shared_mass,
    "contact": _stop,
    "cable_drag": _cable,
    "windage": _fan,
    "magnet_detent": _magnet,
    "creep": _creep,
    "gyroscope": _wheel,
}
