"""The torque regressor of the rigid bodies, vectorised over samples.

τ(q, q̇, q̈) = Y(q, q̇, q̈)·h with h the standard parameters of all links, link by link
(Khalil & Dombre, *Modeling, Identification and Control of Robots*, ch. 9). The kernel runs the
Newton-Euler recursion once per sample and projects each link's 6×10 body regressor on the
joints that carry it; compiled, because Python around Pinocchio's own one costs ten times more.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]

LANES = 128  # samples that are worked on at once: what they need fits the second-level cache


def regressor(
    robot: Robot,
    q: Array,
    dq: Array,
    ddq: Array,
    columns: NDArray[np.int64] | None = None,
    out: Array | None = None,
) -> Array:
    """Y, shape (N, n, k): torque of joint i at sample s = Y[s, i] @ h[columns].

    q, dq, ddq: (N, n) rad, rad/s, rad/s² (m … for prismatic joints).
    columns: (k,) indices into the 10·n standard parameters, link-major; default all.
    out: zeros (N, n, k) in any memory order, to be filled and returned.
    """
    n = robot.n
    chosen = np.arange(10 * n) if columns is None else np.asarray(columns, dtype=np.int64)
    place = np.full(10 * n, -1, dtype=np.int64)
    place[chosen] = np.arange(len(chosen))
    if out is None:
        out = np.zeros((len(q), n, len(chosen)))
    _fill(
        np.ascontiguousarray(q, dtype=float),
        np.ascontiguousarray(dq, dtype=float),
        np.ascontiguousarray(ddq, dtype=float),
        *_tree(robot),
        place,
        out,
    )
    return out


def _tree(robot: Robot) -> tuple[NDArray, ...]:
    return (
        robot.parent,
        robot.order,
        np.ascontiguousarray(robot.rotation),
        np.ascontiguousarray(robot.translation),
        np.ascontiguousarray(robot.axis),
        robot.prismatic,
        np.ascontiguousarray(robot.gravity),
    )


@numba.njit(cache=True, nogil=True)
def _joint_frame(fixed, axis, angle, out):
    """out = fixed · Rot(axis, angle) (Rodrigues)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = axis
    t = 1.0 - c
    turn = (
        (t * x * x + c, t * x * y - s * z, t * x * z + s * y),
        (t * x * y + s * z, t * y * y + c, t * y * z - s * x),
        (t * x * z - s * y, t * y * z + s * x, t * z * z + c),
    )
    for i in range(3):
        for k in range(3):
            out[i, k] = (
                fixed[i, 0] * turn[0][k] + fixed[i, 1] * turn[1][k] + fixed[i, 2] * turn[2][k]
            )


@numba.njit(cache=True, nogil=True)
def _fill(q, dq, ddq, parent, order, fixed, offset, axis, prismatic, gravity, place, out):
    """LANES samples side by side: every statement is a loop over them, which the compiler turns
    into vector instructions."""
    samples, n = q.shape
    turn, arm = np.zeros((n, 3, 3, LANES)), np.zeros((n, 3, LANES))  # turn[j, k]: column k of rot
    w, dw, a = np.zeros((n, 3, LANES)), np.zeros((n, 3, LANES)), np.zeros((n, 3, LANES))
    spin, shift = np.zeros((n, n, 3, LANES)), np.zeros((n, n, 3, LANES))  # joint i's twist in j
    force, moment = np.zeros((3, 3, LANES)), np.zeros((6, 3, LANES))
    t1, t2, row = np.zeros((3, LANES)), np.zeros((3, LANES)), np.zeros(LANES)
    base, zero = np.zeros((3, LANES)), np.zeros((3, LANES))
    for k in range(3):
        base[k] = -gravity[k]
    for j in range(n):
        for k in range(3):
            spin[j, j, k] = 0.0 if prismatic[j] else axis[j, k]
            shift[j, j, k] = axis[j, k] if prismatic[j] else 0.0
    for start in range(0, samples, LANES):
        lanes = min(LANES, samples - start)
        for j in order:
            _frames(q[start : start + lanes, j], fixed[j], offset[j], axis[j], prismatic[j],
                    turn[j], arm[j])  # fmt: skip
            p = parent[j]
            _link_motion(
                dq[start : start + lanes, j], ddq[start : start + lanes, j], axis[j], prismatic[j],
                turn[j], arm[j], w[p] if p >= 0 else zero, dw[p] if p >= 0 else zero,
                a[p] if p >= 0 else base, w[j], dw[j], a[j], t1, t2,
            )  # fmt: skip
            _body(w[j], dw[j], force, moment)
            i = p
            while i >= 0:  # twists of the joints that carry link j, in its frame
                _cross_lanes(spin[p, i], arm[j], t1)
                for k in range(3):
                    _add(t1[k], shift[p, i, k], t2[k])
                for k in range(3):
                    _dot(turn[j, k], t2, shift[j, i, k])
                    _dot(turn[j, k], spin[p, i], spin[j, i, k])
                i = parent[i]
            i = j
            while i >= 0:
                sp, sh = spin[j, i], shift[j, i]
                c = place[10 * j]
                if c >= 0:
                    _dot(sh, a[j], row)
                    _put(row, lanes, start, out[:, i, c])
                # first moments also give a moment mc × a: row k of spin·(-S(a))
                _cross_lanes(a[j], sp, t1)
                for k in range(3):
                    c = place[10 * j + 1 + k]
                    if c >= 0:
                        _dot(sh, force[k], row)
                        _add(row, t1[k], t2[k])
                        _put(t2[k], lanes, start, out[:, i, c])
                for k in range(6):
                    c = place[10 * j + 4 + k]
                    if c >= 0:
                        _dot(sp, moment[k], row)
                        _put(row, lanes, start, out[:, i, c])
                i = parent[i]


@numba.njit(cache=True, nogil=True)
def _frames(q, fixed, offset, axis, prismatic, turn, arm):
    rot = np.empty((3, 3))
    for s in range(len(q)):
        if prismatic:
            rot[:] = fixed
        else:
            _joint_frame(fixed, axis, q[s], rot)
        for i in range(3):
            along = fixed[i, 0] * axis[0] + fixed[i, 1] * axis[1] + fixed[i, 2] * axis[2]
            arm[i, s] = offset[i] + q[s] * along if prismatic else offset[i]
            for k in range(3):
                turn[k, i, s] = rot[i, k]


@numba.njit(cache=True, nogil=True)
def _link_motion(dq, ddq, axis, prismatic, turn, arm, wp, dwp, ap, w, dw, a, t1, t2):
    """Angular rates and origin acceleration of one link from its parent's."""
    _cross_lanes(wp, arm, t1)
    _cross_lanes(wp, t1, t2)
    _cross_lanes(dwp, arm, t1)
    for k in range(3):
        for s in range(LANES):
            t2[k, s] += ap[k, s] + t1[k, s]
    for k in range(3):
        _dot(turn[k], t2, a[k])
        _dot(turn[k], wp, w[k])
        _dot(turn[k], dwp, dw[k])
    for s in range(len(dq)):
        x, y, z = w[0, s], w[1, s], w[2, s]
        across = (y * axis[2] - z * axis[1], z * axis[0] - x * axis[2], x * axis[1] - y * axis[0])
        for k in range(3):
            if prismatic:
                a[k, s] += 2.0 * across[k] * dq[s] + axis[k] * ddq[s]
            else:
                dw[k, s] += across[k] * dq[s] + axis[k] * ddq[s]
                w[k, s] += axis[k] * dq[s]


@numba.njit(cache=True, nogil=True)
def _body(w, dw, force, moment):
    """force (3, 3, L): first moment k -> force, S(dw) + S(w)S(w); moment (6, 3, L): inertia xx xy
    yy xz yz zz -> moment, L(dw) + S(w)L(w)."""
    for s in range(LANES):
        x, y, z = w[0, s], w[1, s], w[2, s]
        u, v, r = dw[0, s], dw[1, s], dw[2, s]
        force[0, 0, s], force[1, 1, s], force[2, 2, s] = (
            -y * y - z * z, -x * x - z * z, -x * x - y * y
        )  # fmt: skip
        force[1, 0, s], force[0, 1, s] = x * y - r, x * y + r
        force[2, 0, s], force[0, 2, s] = x * z + v, x * z - v
        force[2, 1, s], force[1, 2, s] = y * z - u, y * z + u
        moment[0, 0, s], moment[0, 1, s], moment[0, 2, s] = u, x * z, -x * y
        moment[1, 0, s], moment[1, 1, s], moment[1, 2, s] = v - x * z, u + y * z, x * x - y * y
        moment[2, 0, s], moment[2, 1, s], moment[2, 2, s] = -y * z, v, x * y
        moment[3, 0, s], moment[3, 1, s], moment[3, 2, s] = r + x * y, z * z - x * x, u - y * z
        moment[4, 0, s], moment[4, 1, s], moment[4, 2, s] = y * y - z * z, r - x * y, v + x * z
        moment[5, 0, s], moment[5, 1, s], moment[5, 2, s] = y * z, -x * z, r


@numba.njit(cache=True, nogil=True)
def _cross_lanes(a, b, out):
    """a × b, (3, L) each."""
    for s in range(LANES):
        out[0, s] = a[1, s] * b[2, s] - a[2, s] * b[1, s]
    for s in range(LANES):
        out[1, s] = a[2, s] * b[0, s] - a[0, s] * b[2, s]
    for s in range(LANES):
        out[2, s] = a[0, s] * b[1, s] - a[1, s] * b[0, s]


@numba.njit(cache=True, nogil=True)
def _dot(a, b, out):
    """(L,): a · b, (3, L) each."""
    for s in range(LANES):
        out[s] = a[0, s] * b[0, s] + a[1, s] * b[1, s] + a[2, s] * b[2, s]


@numba.njit(cache=True, nogil=True)
def _add(a, b, out):
    for s in range(LANES):
        out[s] = a[s] + b[s]


@numba.njit(cache=True, nogil=True)
def _put(row, lanes, start, out):
    for s in range(lanes):
        out[start + s] = row[s]
