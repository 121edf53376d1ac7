"""Effects that tie joints together or act at an angle: a list of instances, any number of each.

Torques that follow from angles and velocities (springs, stops, ripple, oddities), friction and
inertia shared by two rotors, and springs that forget.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from backends.virtual.plant.compiled import inner
from backends.virtual.plant.hidden import Hidden
from backends.virtual.plant.records import Array, Record, Table

RIPPLE, SPRING, STOP, CABLE, WIND, MAGNET, WHEEL, CREEP, BELT, MASS, CLAMP = range(11)

# effect → kind and the parameters that become a, b, c, d
KINDS: dict[str, tuple[int, tuple[str, ...]]] = {
    "torque_ripple": (RIPPLE, ("N", "sin", "cos")),
    "spring": (SPRING, ("k", "q0")),
    "contact": (STOP, ("k", "qs", "side", "damping")),
    "cable_drag": (CABLE, ("amplitude", "phase")),
    "windage": (WIND, ("drag",)),
    "magnet_detent": (MAGNET, ("pull", "centre", "width")),
    "gyroscope": (WHEEL, ("amplitude",)),
    "creep": (CREEP, ("k", "T")),
    "coupling_friction": (BELT, ("F", "Fv", "sign")),
    "coupling_inertia": (MASS, ("Ia",)),
    "cross_friction": (CLAMP, ("amplitude", "cycles")),
}
ROW = np.dtype(
    [("kind", np.int64), ("i", np.int64), ("j", np.int64)] + [(p, float) for p in "abcd"]
)


def extras_of(effects: Sequence[Hidden]) -> Table:
    """(m,) rows: kind, joints i and j (0-based, equal where there is one), parameters a to d."""
    rows = []
    for effect in effects:
        if effect.effect in KINDS:
            kind, keys = KINDS[effect.effect]
            values = [effect[key] for key in keys] + [0.0] * (4 - len(keys))
            rows.append((kind, effect.joints[0], effect.joints[-1], *values))
    return np.array(rows, ROW)


@inner
def on_rotors(
    extras: Table, joints: Table, q: Array, mass: Array, damping: Array, out: Array
) -> None:
    """Add what acts before the gear: torque to ``out``, shared inertia, viscous drag."""
    for r in range(extras.shape[0]):
        row = extras[r]
        i, j = joints[row.i].rotor, joints[row.j].rotor
        if row.kind == RIPPLE:
            out[i] -= row.b * math.sin(row.a * q[i]) + row.c * math.cos(row.a * q[i])
        elif row.kind == MASS:
            mass[i, j] += row.a
            mass[j, i] += row.a
        elif row.kind == BELT:
            damping[i, i] += row.b
            damping[j, j] += row.b * row.c * row.c
            damping[i, j] += row.b * row.c
            damping[j, i] += row.b * row.c


@inner
def on_links(extras: Table, q: Array, v: Array, stretch: Array, damping: Array, out: Array) -> None:
    """Add what acts on the links: torque to ``out``, drag to ``damping``."""
    for r in range(extras.shape[0]):
        row = extras[r]
        i, j = row.i, row.j
        if row.kind == SPRING:
            out[i] -= row.a * (q[i] - row.b)
        elif row.kind == STOP:
            push = row.a * row.c * (q[i] - row.b)
            if push > 0.0 and push + row.d * row.c * v[i] > 0.0:
                out[i] -= row.c * push
                damping[i, i] += row.d
        elif row.kind == CABLE:
            out[i] -= row.a * math.sin(q[i]) * math.sin(q[j] + row.b)
        elif row.kind == WIND:
            out[i] -= row.a * q[i] * abs(v[i]) * v[i]
        elif row.kind == MAGNET:
            x = (q[i] - row.b) / row.c
            out[i] -= row.a * x * math.exp(0.5 - 0.5 * x * x)
        elif row.kind == WHEEL:
            out[i] -= row.a * v[i] * v[j]
        elif row.kind == CREEP:
            out[i] -= row.a * stretch[r]


@inner
def bent_by_others(extras: Table, j: int, angles: Array) -> float:
    """What other joints' angles add to the friction level of joint j, N·m."""
    out = 0.0
    for r in range(extras.shape[0]):
        row = extras[r]
        if row.kind == CLAMP and row.i == j:
            out += row.a * math.sin(row.b * angles[row.j])
    return out


@inner
def relax(row: Record, stretch: float, speed: float, h: float) -> float:
    """Stretch of a forgetting spring after h seconds at this mean speed."""
    kept = math.exp(-h / row.b)
    return stretch * kept + speed * row.b * (1.0 - kept)
