"""How finely time must be cut for the stiffest spring of an arm."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
from scipy.linalg import eigh

from backends.virtual.plant.arm import as_pinocchio
from backends.virtual.plant.bristles import MAXWELL
from backends.virtual.plant.extras import MASS, SPRING, STOP
from backends.virtual.plant.records import Array
from backends.virtual.plant.state import Physics

LONGEST_SUBSTEP = 0.5e-3  # s
FINEST_PHASE = 0.25  # rad of the fastest mode per substep: frequency wrong by 0.3 %


def longest_substep(physics: Physics) -> float:
    """The substep that resolves the fastest spring of this arm, s."""
    mass = inertias(physics)
    n, size = len(physics.transmission.rotor), mass.shape[1]
    stiffness = np.zeros((size, size))
    tr, br = physics.transmission, physics.bristles
    for j in range(n):
        d = tr.rotor[j]
        if d != j:
            stiffness[np.ix_([j, d], [j, d])] += tr.stiffness[j] * np.array([[1, -1], [-1, 1]])
        level = physics.friction.coulomb[j] + physics.friction.rise[j]
        slipping = level * np.sum(br.share[j] / br.slip[j]) if br.bristles[j] == MAXWELL else 0.0
        stiffness[d, d] += br.sigma0[j] + slipping
    for row in physics.extras:
        if row["kind"] in (SPRING, STOP):
            stiffness[row["i"], row["i"]] += abs(row["a"])
    fastest = max(float(eigh(stiffness, m, eigvals_only=True)[-1]) for m in mass)
    return min(LONGEST_SUBSTEP, FINEST_PHASE / math.sqrt(max(fastest, 1.0)))


def inertias(physics: Physics, poses: int = 6) -> Array:
    """Mass matrices over all coordinates at a few poses, (poses, N, N)."""
    tr = physics.transmission
    n, size = len(tr.rotor), physics.size
    model = as_pinocchio(physics.arm)
    data = model.createData()
    rng = np.random.default_rng(0)
    out = np.zeros((poses, size, size))
    for mass in out:
        upper = np.triu(pin.crba(model, data, rng.uniform(-1.5, 1.5, n)))
        mass[:n, :n] = upper + np.triu(upper, 1).T
        mass[tr.rotor, tr.rotor] += tr.inertia
        for row in physics.extras:
            if row["kind"] == MASS:
                i, j = tr.rotor[row["i"]], tr.rotor[row["j"]]
                mass[i, j] += row["a"]
                mass[j, i] += row["a"]
    return out
