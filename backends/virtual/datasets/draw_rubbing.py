"""Friction of a size that shows."""

from __future__ import annotations

import math

from backends.virtual.datasets.figures import (
    Draw,
    Figures,
    Rng,
    another,
    any_joint,
    carrying,
    neighbours,
    sign,
)
from pa10d.common.jsonable import JsonObject


def _asymmetry(rng: Rng, f: Figures) -> JsonObject:
    j, side = any_joint(rng, f), sign(rng)
    return {
        "joint": j + 1,
        "dFc": side * rng.uniform(0.1, 0.3) * f.book.coulomb[j],
        "dFv": side * rng.uniform(0.15, 0.4) * f.book.viscous[j],
    }


def _stribeck(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f)
    return {
        "joint": j + 1,
        "Fs": rng.uniform(0.3, 0.9) * f.book.coulomb[j],
        "vs": rng.uniform(0.03, 0.12) * f.reach.speed[j],
        "delta": rng.uniform(1.0, 2.0),
    }


def _power_law(rng: Rng, f: Figures) -> JsonObject:
    j, p = any_joint(rng, f), rng.uniform(1.7, 2.6)
    top = 0.7 * f.reach.speed[j]
    return {"joint": j + 1, "Fp": rng.uniform(0.5, 1.2) * f.book.coulomb[j] / top**p, "p": p}


def _presliding(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f)
    share = 0.004 * f.reach.half[j]  # rad before it slides
    if rng.random() < 0.5:
        stretch = share * rng.uniform(0.6, 2.0)
        scale = [float(f"{stretch * k:.3g}") for k in (0.15, 0.5, 1.2, 3.0)]
        return {"joint": j + 1, "model": "maxwell", "displacements": scale}
    sigma0 = f.book.coulomb[j] / (share * rng.uniform(0.6, 2.0))
    sigma1 = rng.uniform(0.1, 0.5) * math.sqrt(sigma0 * f.book.rotor_inertia[j])
    return {"joint": j + 1, "model": "lugre", "sigma0": sigma0, "sigma1": sigma1}


def _load(rng: Rng, f: Figures) -> JsonObject:
    mu = rng.uniform(0.04, 0.12)
    return {"joint": any_joint(rng, f, 0.04 * 2 * carrying(f)) + 1, "mu": mu}


def _thermal(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f)
    typical = 0.3 * f.reach.speed[j]
    power = (f.book.coulomb[j] + f.book.viscous[j] * typical) * typical
    return {
        "joint": j + 1,
        "loss": rng.uniform(0.25, 0.5),
        "T": rng.uniform(8.0, 30.0),
        "coulomb_share": rng.uniform(0.3, 1.0),
        "law": str(rng.choice(["time", "time", "power"])),
        "power": power,
    }


def _worn(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f)
    if rng.random() < 0.5:
        wave = rng.uniform(0.25, 0.6) * f.book.coulomb[j]
        turns = {"cycles": float(rng.integers(1, 4)), "phase": rng.uniform(0, 6.28)}
        return {"joint": j + 1, "wave": wave, **turns}
    return {
        "joint": j + 1,
        "height": rng.uniform(0.4, 1.0) * f.book.coulomb[j],
        "centre": f.reach.middle[j] + rng.uniform(-0.2, 0.2) * f.reach.half[j],
        "width": rng.uniform(0.05, 0.12) * f.reach.half[j],
    }


def _shared_belt(rng: Rng, f: Figures) -> JsonObject:
    i, j = neighbours(rng, f)
    size = min(f.book.coulomb[i], f.book.coulomb[j])
    return {"joints": [i + 1, j + 1], "F": rng.uniform(0.25, 0.6) * size, "sign": sign(rng)}


def _bent_clamp(rng: Rng, f: Figures) -> JsonObject:
    i = any_joint(rng, f)
    j = another(rng, f, i)
    turns = math.pi / (1.4 * f.reach.half[j])
    size = rng.uniform(0.3, 0.6) * f.book.coulomb[i]
    return {"joints": [i + 1, j + 1], "amplitude": size, "cycles": turns}


RUBBING: dict[str, Draw] = {
    "coulomb_asymmetry": _asymmetry,
    "stribeck": _stribeck,
    "nonlinear_viscous": _power_law,
    "presliding_hysteresis": _presliding,
    "load_friction": _load,
    "thermal_friction": _thermal,
    "position_friction": _worn,
    "coupling_friction": _shared_belt,
    "cross_friction": _bent_clamp,
}
