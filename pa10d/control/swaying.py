"""Joints that sway together: integral action no stronger than soft neighbours leave room for.

Gains are made joint by joint, the others held. But a servo gives way, and where two joints stand
upright one above the other both lean to the same side: gravity pulls harder than at either alone,
and more mass sways, so slowly that integral action feeds the sway. Of a whole arm about a pose
M·s² + D·s + K + I/s is left (Lancaster, Lambda-Matrices and Vibrating Systems, 1966); K is the
stiffness less gravity's slope, and delay takes some of D and K. Without I it comes to rest if K is
positive: so the integral action of joints that sway is lowered until nothing sways up. What a joint
does alone, and fast, the margins look after.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DAMPED = 0.1  # of critical damping, at least: a heavy joint alone is allowed to sway as slowly
LESS = 0.7  # of the integral action, per step
STEPS = 20  # down to a thousandth
PART = 0.3  # of what the joint feeds that feeds a sway most: whoever feeds as much is lowered too


@dataclass(frozen=True)
class Coupled:
    """An arm about P poses. mass: (P, n, n) kg·m² with rotors; slope: (P, n, n) N·m/rad by which
    gravity pulls away; stiff, damps: (n,) N·m/rad and N·m·s/rad of servo and friction; late: (n,) s
    of delay."""

    mass: Array
    slope: Array
    stiff: Array
    damps: Array
    late: Array

    def standing(self) -> Coupled:
        """In those poses alone in which stiffness by itself holds it: where gravity is stronger,
        less integral action does not help."""
        held = np.linalg.eigvalsh(np.diag(self.stiff) - self.slope)[:, 0] > 0
        return Coupled(self.mass[held], self.slope[held], self.stiff, self.damps, self.late)

    def system(self, integral: Array) -> Array:
        """(P, 3n, 3n) state matrices of sum, angle and speed."""
        n = len(self.stiff)
        still, unit = np.zeros((n, n)), np.eye(n)
        k = np.diag(self.stiff - integral * self.late) - self.slope
        d = np.diag(self.damps - self.stiff * self.late)
        forces = np.concatenate(
            [np.broadcast_to(np.diag(integral), k.shape), k, np.broadcast_to(d, k.shape)], axis=2
        )
        top = np.block([[still, unit, still], [still, still, unit]])
        tops = np.broadcast_to(top, (len(k), *top.shape))
        moved = np.asarray(np.linalg.solve(self.mass, forces), dtype=float)
        return np.concatenate([tops, -moved], axis=1)


def settled(arm: Coupled, integral: Array) -> Array:
    """(n,) N·m/(rad·s): ``integral``, or less of it, with which nothing sways up in any pose."""
    arm, chosen = arm.standing(), integral.copy()
    if not len(arm.mass):
        return chosen
    n = len(integral)
    for _ in range(STEPS):
        roots, modes = np.linalg.eig(arm.system(chosen))
        undamped = roots.real + DAMPED * np.abs(roots)
        pose, mode = np.nonzero((undamped > 0) & (roots.imag > 0))
        if not len(pose):
            break
        feeds = chosen * np.abs(modes[pose, n : 2 * n, mode]) ** 2  # what integral action gives
        most = feeds.max(axis=1, keepdims=True)
        chosen[(feeds >= PART * np.maximum(most, 1e-300)).any(axis=0)] *= LESS
    return chosen
