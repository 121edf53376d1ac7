"""Rigid-body torques at given velocities in compiled code (recursive Newton-Euler).

Everything is expressed in the joints' own frames. ``frames`` holds the intermediate vectors so
that a step allocates nothing. Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 5.
"""

from __future__ import annotations

import math

import numpy as np

from backends.virtual.plant.compiled import inner
from backends.virtual.plant.records import Array, Record, Table, blank


def frames(n: int) -> Table:
    """Scratch records of n joints: rotation to the parent, origin in it, velocities, wrenches."""
    vectors = ("origin", "spin", "spin_rate", "acceleration", "force", "moment", "first")
    shapes: dict[str, tuple[int, ...]] = {name: (3,) for name in vectors}
    return blank(n, turn=(3, 3), second=(3, 3), mass=(), **shapes)


@inner
def cross(a: Array, b: Array, out: Array) -> None:
    """out += a × b."""
    out[0] += a[1] * b[2] - a[2] * b[1]
    out[1] += a[2] * b[0] - a[0] * b[2]
    out[2] += a[0] * b[1] - a[1] * b[0]


@inner
def place(bodies: Table, q: Array, work: Table) -> None:
    """Rotation and origin of every joint frame in its parent's frame."""
    for i in range(q.shape[0]):
        s = bodies[i].axis
        for a in range(3):
            work[i].origin[a] = bodies[i].offset[a]
        if bodies[i].prismatic:
            for a in range(3):
                for b in range(3):
                    work[i].turn[a, b] = bodies[i].rotation[a, b]
                    work[i].origin[a] += bodies[i].rotation[a, b] * s[b] * q[i]
            continue
        c, d = math.cos(q[i]), math.sin(q[i])
        e = 1.0 - c
        r00, r01, r02 = c + e * s[0] * s[0], e * s[0] * s[1] - d * s[2], e * s[0] * s[2] + d * s[1]
        r10, r11, r12 = e * s[1] * s[0] + d * s[2], c + e * s[1] * s[1], e * s[1] * s[2] - d * s[0]
        r20, r21, r22 = e * s[2] * s[0] - d * s[1], e * s[2] * s[1] + d * s[0], c + e * s[2] * s[2]
        for a in range(3):
            x, y, z = bodies[i].rotation[a, 0], bodies[i].rotation[a, 1], bodies[i].rotation[a, 2]
            work[i].turn[a, 0] = x * r00 + y * r10 + z * r20
            work[i].turn[a, 1] = x * r01 + y * r11 + z * r21
            work[i].turn[a, 2] = x * r02 + y * r12 + z * r22


@inner
def bias(bodies: Table, gravity: Array, dq: Array, work: Table, out: Array) -> None:
    """Torques that gravity and the velocities ask for at zero acceleration, (n,), after place()."""
    n = dq.shape[0]
    wp, wdp, lin, tmp = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for i in range(n):
        p, s, r, turn = bodies[i].parent, bodies[i].axis, work[i].origin, work[i].turn
        w, wd, acc = work[i].spin, work[i].spin_rate, work[i].acceleration
        for a in range(3):
            wp[a] = work[p].spin[a] if p >= 0 else 0.0
            wdp[a] = work[p].spin_rate[a] if p >= 0 else 0.0
            lin[a] = work[p].acceleration[a] if p >= 0 else -gravity[a]
            tmp[a] = 0.0
        cross(wp, r, tmp)
        cross(wp, tmp, lin)
        cross(wdp, r, lin)
        for a in range(3):
            w[a] = turn[0, a] * wp[0] + turn[1, a] * wp[1] + turn[2, a] * wp[2]
            wd[a] = turn[0, a] * wdp[0] + turn[1, a] * wdp[1] + turn[2, a] * wdp[2]
            acc[a] = turn[0, a] * lin[0] + turn[1, a] * lin[1] + turn[2, a] * lin[2]
            tmp[a] = s[a] * dq[i]
        if bodies[i].prismatic:
            for a in range(3):
                tmp[a] *= 2.0
            cross(w, tmp, acc)
        else:
            cross(w, tmp, wd)
            for a in range(3):
                w[a] += tmp[a]
        _wrench(bodies[i], work[i], tmp, lin)
    for i in range(n - 1, -1, -1):
        s = bodies[i].axis
        load = work[i].force if bodies[i].prismatic else work[i].moment
        out[i] = s[0] * load[0] + s[1] * load[1] + s[2] * load[2]
        p = bodies[i].parent
        if p >= 0:
            for a in range(3):
                tmp[a] = lin[a] = 0.0
                for b in range(3):
                    tmp[a] += work[i].turn[a, b] * work[i].force[b]
                    lin[a] += work[i].turn[a, b] * work[i].moment[b]
            for a in range(3):
                work[p].force[a] += tmp[a]
                work[p].moment[a] += lin[a]
            cross(work[i].origin, tmp, work[p].moment)


@inner
def _wrench(body: Record, frame: Record, tmp: Array, spun: Array) -> None:
    """Force and moment (about the joint's origin) that accelerate the body as frame says."""
    w, wd, c = frame.spin, frame.spin_rate, body.com
    force, moment, inertia = frame.force, frame.moment, body.inertia
    for a in range(3):
        tmp[a] = 0.0
        force[a] = frame.acceleration[a]
    cross(w, c, tmp)
    cross(w, tmp, force)
    cross(wd, c, force)
    for a in range(3):
        force[a] *= body.mass
        spun[a] = inertia[a, 0] * w[0] + inertia[a, 1] * w[1] + inertia[a, 2] * w[2]
        moment[a] = inertia[a, 0] * wd[0] + inertia[a, 1] * wd[1] + inertia[a, 2] * wd[2]
    cross(w, spun, moment)
    cross(c, force, moment)
