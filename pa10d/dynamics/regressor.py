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


def inverse_dynamics(robot: Robot, parameters: Array, q: Array, dq: Array, ddq: Array) -> Array:
    """Rigid-body torque (N, n) N·m of standard parameters (n, 10), without forming Y."""
    out = np.empty((len(q), robot.n))
    _torque(
        np.ascontiguousarray(q, dtype=float),
        np.ascontiguousarray(dq, dtype=float),
        np.ascontiguousarray(ddq, dtype=float),
        *_tree(robot),
        np.ascontiguousarray(parameters, dtype=float).reshape(robot.n, 10),
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
def _cross(a, b, out):
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@numba.njit(cache=True, nogil=True)
def _down(rot, v, out):
    """out = rotᵀ v: from the parent's frame into the child's."""
    for k in range(3):
        out[k] = rot[0, k] * v[0] + rot[1, k] * v[1] + rot[2, k] * v[2]


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
def _motion(q, dq, ddq, parent, order, fixed, offset, axis, prismatic, gravity, rot, arm, w, dw, a):
    """Outward recursion for one sample: frames, angular rates and origin accelerations, each
    in its own link's frame; gravity enters as an acceleration of the base."""
    t1, t2, base, zero = np.empty(3), np.empty(3), np.empty(3), np.zeros(3)
    for k in range(3):
        base[k] = -gravity[k]
    for j in order:
        p = parent[j]
        wp = w[p] if p >= 0 else zero
        dwp = dw[p] if p >= 0 else zero
        ap = a[p] if p >= 0 else base
        if prismatic[j]:
            rot[j] = fixed[j]
            for k in range(3):
                arm[j, k] = offset[j, k] + q[j] * (
                    fixed[j, k, 0] * axis[j, 0]
                    + fixed[j, k, 1] * axis[j, 1]
                    + fixed[j, k, 2] * axis[j, 2]
                )
        else:
            _joint_frame(fixed[j], axis[j], q[j], rot[j])
            for k in range(3):
                arm[j, k] = offset[j, k]
        _cross(wp, arm[j], t1)
        _cross(wp, t1, t2)
        _cross(dwp, arm[j], t1)
        for k in range(3):
            t2[k] += ap[k] + t1[k]
        _down(rot[j], t2, a[j])
        _down(rot[j], wp, w[j])
        _down(rot[j], dwp, dw[j])
        _cross(w[j], axis[j], t1)
        if prismatic[j]:
            for k in range(3):
                a[j, k] += 2.0 * t1[k] * dq[j] + axis[j, k] * ddq[j]
        else:
            for k in range(3):
                dw[j, k] += t1[k] * dq[j] + axis[j, k] * ddq[j]
                w[j, k] += axis[j, k] * dq[j]


@numba.njit(cache=True, nogil=True)
def _fill(q, dq, ddq, parent, order, fixed, offset, axis, prismatic, gravity, place, out):
    samples, n = q.shape
    rot, arm = np.empty((n, 3, 3)), np.empty((n, 3))
    w, dw, a = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    spin, shift = np.empty((n, n, 3)), np.empty((n, n, 3))  # twist of joint i seen in frame j
    force, moment, turned = np.empty((3, 3)), np.empty((3, 6)), np.empty(3)
    for s in range(samples):
        _motion(
            q[s], dq[s], ddq[s], parent, order, fixed, offset, axis, prismatic, gravity,
            rot, arm, w, dw, a,
        )  # fmt: skip
        for j in order:
            x, y, z = w[j]
            # first moments -> force: S(dw) + S(w)S(w)
            force[0, 0], force[1, 1], force[2, 2] = -y * y - z * z, -x * x - z * z, -x * x - y * y
            force[0, 1], force[1, 0] = x * y - dw[j, 2], x * y + dw[j, 2]
            force[0, 2], force[2, 0] = x * z + dw[j, 1], x * z - dw[j, 1]
            force[1, 2], force[2, 1] = y * z - dw[j, 0], y * z + dw[j, 0]
            # inertia -> moment: L(dw) + S(w)L(w), columns xx xy yy xz yz zz
            u, v, r = dw[j]
            moment[0, 0], moment[1, 0], moment[2, 0] = u, x * z, -x * y
            moment[0, 1], moment[1, 1], moment[2, 1] = v - x * z, u + y * z, x * x - y * y
            moment[0, 2], moment[1, 2], moment[2, 2] = -y * z, v, x * y
            moment[0, 3], moment[1, 3], moment[2, 3] = r + x * y, z * z - x * x, u - y * z
            moment[0, 4], moment[1, 4], moment[2, 4] = y * y - z * z, r - x * y, v + x * z
            moment[0, 5], moment[1, 5], moment[2, 5] = y * z, -x * z, r
            # twists of the joints that carry link j, in its frame
            p, i = parent[j], parent[j]
            while i >= 0:
                _cross(spin[p, i], arm[j], turned)
                for k in range(3):
                    turned[k] += shift[p, i, k]
                _down(rot[j], turned, shift[j, i])
                _down(rot[j], spin[p, i], spin[j, i])
                i = parent[i]
            for k in range(3):
                spin[j, j, k] = 0.0 if prismatic[j] else axis[j, k]
                shift[j, j, k] = axis[j, k] if prismatic[j] else 0.0
            i = j
            while i >= 0:
                sp, sh = spin[j, i], shift[j, i]
                c = place[10 * j]
                if c >= 0:
                    out[s, i, c] = sh[0] * a[j, 0] + sh[1] * a[j, 1] + sh[2] * a[j, 2]
                # first moments also give a moment mc × a: row k of spin·(-S(a))
                _cross(a[j], sp, turned)
                for k in range(3):
                    c = place[10 * j + 1 + k]
                    if c >= 0:
                        out[s, i, c] = (
                            sh[0] * force[0, k] + sh[1] * force[1, k] + sh[2] * force[2, k]
                            + turned[k]
                        )  # fmt: skip
                for k in range(6):
                    c = place[10 * j + 4 + k]
                    if c >= 0:
                        out[s, i, c] = (
                            sp[0] * moment[0, k] + sp[1] * moment[1, k] + sp[2] * moment[2, k]
                        )
                i = parent[i]


@numba.njit(cache=True, nogil=True)
def _torque(q, dq, ddq, parent, order, fixed, offset, axis, prismatic, gravity, h, out):
    samples, n = q.shape
    rot, arm = np.empty((n, 3, 3)), np.empty((n, 3))
    w, dw, a = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    f, m = np.empty((n, 3)), np.empty((n, 3))
    t1, t2, t3, lw, ldw = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for s in range(samples):
        _motion(
            q[s], dq[s], ddq[s], parent, order, fixed, offset, axis, prismatic, gravity,
            rot, arm, w, dw, a,
        )  # fmt: skip
        for j in range(n):
            mc = h[j, 1:4]
            _cross(w[j], mc, t1)
            _cross(w[j], t1, t2)
            _cross(dw[j], mc, t1)
            _inertia_times(h[j], w[j], lw)
            _inertia_times(h[j], dw[j], ldw)
            _cross(w[j], lw, t3)
            for k in range(3):
                f[j, k] = h[j, 0] * a[j, k] + t1[k] + t2[k]
                m[j, k] = ldw[k] + t3[k]
            _cross(mc, a[j], t1)
            for k in range(3):
                m[j, k] += t1[k]
        for position in range(n - 1, -1, -1):
            j = order[position]
            load = f[j] if prismatic[j] else m[j]
            out[s, j] = axis[j, 0] * load[0] + axis[j, 1] * load[1] + axis[j, 2] * load[2]
            p = parent[j]
            if p >= 0:
                for k in range(3):
                    t1[k] = rot[j, k, 0] * f[j, 0] + rot[j, k, 1] * f[j, 1] + rot[j, k, 2] * f[j, 2]
                    t2[k] = rot[j, k, 0] * m[j, 0] + rot[j, k, 1] * m[j, 1] + rot[j, k, 2] * m[j, 2]
                _cross(arm[j], t1, t3)
                for k in range(3):
                    f[p, k] += t1[k]
                    m[p, k] += t2[k] + t3[k]


@numba.njit(cache=True, nogil=True)
def _inertia_times(h, v, out):
    out[0] = h[4] * v[0] + h[5] * v[1] + h[7] * v[2]
    out[1] = h[5] * v[0] + h[6] * v[1] + h[8] * v[2]
    out[2] = h[7] * v[0] + h[8] * v[1] + h[9] * v[2]
