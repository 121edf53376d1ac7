"""Dry friction as a set-valued law, solved together for all joints at the end of a substep.

Find impulses P within their bounds such that a joint either does not move and P is whatever holds
it, or moves and P is at the bound that opposes it. Projected Gauss-Seidel on the joint-space
inverse inertia; Moreau (1988), Jean (1999). Bounds that grow with the transmitted torque are
renewed in every sweep, so both agree at the instant.
"""

from __future__ import annotations

from backends.virtual.plant.compiled import inner
from backends.virtual.plant.extras import BELT
from backends.virtual.plant.records import Array, Table

SWEEPS = 200
TOLERANCE = 1e-13  # rad/s


@inner
def transmitted_load(
    joints: Table,
    extras: Table,
    work: Table,
    impulse: Array,
    j: int,
    before: Array,
    after: Array,
    h: float,
) -> float:
    """Torque that passes from rotor j to its link, from the rotor's own balance, N·m."""
    d, n = joints[j].rotor, joints.shape[0]
    gone = impulse[j]
    for r in range(extras.shape[0]):
        if extras[r].kind == BELT:
            if extras[r].i == j:
                gone += impulse[n + r]
            elif extras[r].j == j:
                gone += impulse[n + r] * extras[r].c
    change = after[d] - before[d]
    mean = before[d] + 0.5 * change
    return work[j].entering - work[j].drag * mean + (gone - joints[j].inertia * change) / h


@inner
def rub(
    joints: Table,
    extras: Table,
    work: Table,
    inverse: Array,
    impulse: Array,
    before: Array,
    after: Array,
    h: float,
) -> None:
    """Turn the frictionless ``after`` into the velocities with dry friction; keeps ``impulse``."""
    n, size = joints.shape[0], after.shape[0]
    for j in range(n):  # start from the last substep's solution
        for i in range(size):
            after[i] += inverse[i, joints[j].rotor] * impulse[j]
    for r in range(extras.shape[0]):
        if extras[r].kind == BELT:
            _kick(joints, extras, inverse, r, impulse[n + r], after)
    for _ in range(SWEEPS):
        change = 0.0
        for j in range(n):
            d = joints[j].rotor
            forward, backward = work[j].forward, work[j].backward
            if joints[j].mu > 0.0:
                load = transmitted_load(joints, extras, work, impulse, j, before, after, h)
                forward += joints[j].mu * abs(load) + joints[j].dmu * load
                backward += joints[j].mu * abs(load) - joints[j].dmu * load
            wanted = impulse[j] - after[d] / inverse[d, d]
            bounded = min(max(wanted, -h * forward), h * backward)
            work[j].sticks = 1.0 if wanted == bounded and forward + backward > 0.0 else 0.0
            delta = bounded - impulse[j]
            impulse[j] = bounded
            if delta != 0.0:
                change = max(change, abs(delta) * inverse[d, d])
                for i in range(size):
                    after[i] += inverse[i, d] * delta
        for r in range(extras.shape[0]):
            if extras[r].kind == BELT:
                delta = _belt(joints, extras, inverse, impulse, r, after, h)
                change = max(change, abs(delta))
        if change < TOLERANCE:
            break
    for j in range(n):
        if work[j].sticks != 0.0:
            after[joints[j].rotor] = 0.0


@inner
def _belt(
    joints: Table, extras: Table, inverse: Array, impulse: Array, r: int, after: Array, h: float
) -> float:
    """Solve one shared friction with the others as they are → change of the slip, rad/s."""
    at = joints.shape[0] + r
    i, k, sign = joints[extras[r].i].rotor, joints[extras[r].j].rotor, extras[r].c
    own = inverse[i, i] + 2.0 * sign * inverse[i, k] + sign * sign * inverse[k, k]
    wanted = impulse[at] - (after[i] + sign * after[k]) / own
    bound = h * extras[r].a
    delta = min(max(wanted, -bound), bound) - impulse[at]
    impulse[at] += delta
    _kick(joints, extras, inverse, r, delta, after)
    return delta * own


@inner
def _kick(
    joints: Table, extras: Table, inverse: Array, r: int, impulse: float, after: Array
) -> None:
    i, k = joints[extras[r].i].rotor, joints[extras[r].j].rotor
    for a in range(after.shape[0]):
        after[a] += (inverse[a, i] + extras[r].c * inverse[a, k]) * impulse
