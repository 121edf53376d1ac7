"""Joint-space mass matrix in compiled code (composite rigid bodies).

Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 6.
"""

from __future__ import annotations

import numpy as np

from backends.virtual.plant.compiled import inner
from backends.virtual.plant.records import Array, Table
from backends.virtual.plant.rigid import cross


@inner
def mass_matrix(bodies: Table, work: Table, out: Array) -> None:
    """Joint-space mass matrix, filled into out[:n, :n], after place()."""
    n = bodies.shape[0]
    _own_bodies(bodies, work)
    force, moment, tmp, lin = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for i in range(n - 1, -1, -1):
        s, h, second = bodies[i].axis, work[i].first, work[i].second
        for a in range(3):
            force[a] = moment[a] = 0.0
        if bodies[i].prismatic:
            for a in range(3):
                force[a] = work[i].mass * s[a]
            cross(h, s, moment)
        else:
            cross(s, h, force)
            for a in range(3):
                moment[a] = second[a, 0] * s[0] + second[a, 1] * s[1] + second[a, 2] * s[2]
        j = i
        while True:
            load = force if bodies[j].prismatic else moment
            sj = bodies[j].axis
            value = sj[0] * load[0] + sj[1] * load[1] + sj[2] * load[2]
            out[i, j] = value
            out[j, i] = value
            p = bodies[j].parent
            if p < 0:
                break
            turn = work[j].turn
            for a in range(3):
                tmp[a] = turn[a, 0] * force[0] + turn[a, 1] * force[1] + turn[a, 2] * force[2]
                lin[a] = turn[a, 0] * moment[0] + turn[a, 1] * moment[1] + turn[a, 2] * moment[2]
            for a in range(3):
                force[a], moment[a] = tmp[a], lin[a]
            cross(work[j].origin, force, moment)
            j = p
        if bodies[i].parent >= 0:
            _hang_on(i, bodies[i].parent, work)


@inner
def _own_bodies(bodies: Table, work: Table) -> None:
    """Mass, first moment and inertia about the joint's origin of each body alone."""
    for i in range(bodies.shape[0]):
        m, c = bodies[i].mass, bodies[i].com
        work[i].mass = m
        square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
        for a in range(3):
            work[i].first[a] = m * c[a]
            for b in range(3):
                work[i].second[a, b] = bodies[i].inertia[a, b] - m * c[a] * c[b]
            work[i].second[a, a] += m * square


@inner
def _hang_on(i: int, p: int, work: Table) -> None:
    """Add composite body i to its parent p: rotate, then shift by the joint's origin."""
    turn, r, m = work[i].turn, work[i].origin, work[i].mass
    g = np.zeros(3)
    for a in range(3):
        for b in range(3):
            g[a] += turn[a, b] * work[i].first[b]
    rr = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    rg = r[0] * g[0] + r[1] * g[1] + r[2] * g[2]
    work[p].mass += m
    for a in range(3):
        work[p].first[a] += g[a] + m * r[a]
        for b in range(3):
            value = -m * r[a] * r[b] - r[a] * g[b] - g[a] * r[b]
            for k in range(3):
                for e in range(3):
                    value += turn[a, k] * work[i].second[k, e] * turn[b, e]
            work[p].second[a, b] += value
        work[p].second[a, a] += m * rr + 2.0 * rg
