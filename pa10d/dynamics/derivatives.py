"""Derivatives of the rigid bodies' torque by position, velocity and acceleration of every joint.

Closed form in one outward and one inward recursion, all joints at once, in the base's frame:
Singh, Russell & Wensing, Efficient Analytical Derivatives of Rigid-Body Dynamics using Spatial
Vector Algebra, IEEE RA-L 7 (2022). Their matrix 2·B of a body needs two sums over its mass only:
its momentum P and G = Σ ṙ·rᵀ·dm; with x = (ω, v) it is 2·B·x = (2(tr G - G)ω, 2 ω × P).
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.regressor import _cross, _joint_frame, _tree
from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]


def sensitivities(
    robot: Robot, parameters: Array, q: Array, dq: Array, ddq: Array
) -> tuple[Array, Array, Array]:
    """∂τ/∂q, ∂τ/∂q̇ and ∂τ/∂q̈ (the mass matrix), each (n, N, n): by joint j, at a sample, of
    joint i. N·m per rad, rad/s, rad/s² (m … for prismatic joints).

    parameters (n, 10) standard parameters, not necessarily feasible; q, dq, ddq (N, n).
    """
    n = robot.n
    out = np.zeros((3, n, len(q), n))
    _derive(
        np.ascontiguousarray(q, dtype=float),
        np.ascontiguousarray(dq, dtype=float),
        np.ascontiguousarray(ddq, dtype=float),
        *_tree(robot),
        np.ascontiguousarray(parameters, dtype=float).reshape(n, 10),
        out,
    )
    return out[0], out[1], out[2]


@numba.njit(cache=True, nogil=True)
def _derive(q, dq, ddq, parent, order, fixed, offset, axis, prismatic, gravity, h, out):
    samples, n = q.shape
    rot, at = np.empty((n, 3, 3)), np.empty((n, 3))  # link frames in the base's
    turn = np.empty((3, 3))
    # spatial motions (angular, linear at the base's origin): axis, its rates, velocity, …
    s, s_rate, by_q, by_q_rate = (
        np.empty((n, 6)), np.empty((n, 6)), np.empty((n, 6)), np.empty((n, 6))
    )  # fmt: skip
    v, a = np.empty((n, 6)), np.empty((n, 6))
    # of all that joint i carries: mass, first moments, inertia about the origin; P, G, wrench
    mass, first, inertia = np.empty(n), np.empty((n, 3)), np.empty((n, 3, 3))
    momentum, g, wrench = np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((n, 6))
    rest, base = np.zeros(6), np.zeros(6)
    base[3:] = -gravity
    t, x, y = np.empty(6), np.empty(6), np.empty(6)
    push, lean = np.empty(6), np.empty(3)
    for k in range(samples):
        for j in order:
            p = parent[j]
            _place(q[k, j], p, fixed[j], offset[j], axis[j], prismatic[j], rot, at, turn, j)
            _axis(rot[j], at[j], axis[j], prismatic[j], s[j])
            vp, ap = (v[p], a[p]) if p >= 0 else (rest, base)
            _motion_cross(vp, s[j], by_q[j])
            _motion_cross(ap, s[j], by_q_rate[j])
            _motion_cross(vp, by_q[j], t)
            for i in range(6):
                by_q_rate[j, i] += t[i]
                v[j, i] = vp[i] + s[j, i] * dq[k, j]
                a[j, i] = ap[i] + s[j, i] * ddq[k, j] + by_q[j, i] * dq[k, j]
            _motion_cross(v[j], s[j], s_rate[j])
            _weigh(h[j], rot[j], at[j], mass, first[j], inertia[j], j)
            _swing(v[j], mass[j], first[j], inertia[j], momentum[j], g[j])
            _times(mass[j], first[j], inertia[j], a[j], wrench[j])
            _times(mass[j], first[j], inertia[j], v[j], x)
            _force_cross(v[j], x, t)
            for i in range(6):
                wrench[j, i] += t[i]
        for position in range(n - 1, -1, -1):
            i = order[position]
            _times(mass[i], first[i], inertia[i], s[i], push)  # sᵢᵀI
            _leaning(g[i], momentum[i], s[i], lean)  # sᵢᵀ2B, which sees angular rates only
            # what moving joint i does to the joints before it
            _times(mass[i], first[i], inertia[i], by_q_rate[i], x)
            _doubled(g[i], momentum[i], by_q[i], t)
            _force_cross(s[i], wrench[i], y)
            for c in range(6):
                x[c] += t[c] + y[c]
            for c in range(6):
                t[c] = by_q[i, c] + s_rate[i, c]
            _times(mass[i], first[i], inertia[i], t, y)
            _doubled(g[i], momentum[i], s[i], t)
            for c in range(6):
                y[c] += t[c]
            j = i
            while j >= 0:
                by_position, by_speed, by_acceleration = 0.0, 0.0, 0.0
                for c in range(6):
                    by_position += push[c] * by_q_rate[j, c]
                    by_speed += push[c] * (by_q[j, c] + s_rate[j, c])
                    by_acceleration += push[c] * s[j, c]
                for c in range(3):
                    by_position += lean[c] * by_q[j, c]
                    by_speed += lean[c] * s[j, c]
                out[0, j, k, i], out[1, j, k, i] = by_position, by_speed
                out[2, j, k, i] = out[2, i, k, j] = by_acceleration
                if j != i:
                    by_position, by_speed = 0.0, 0.0
                    for c in range(6):
                        by_position += s[j, c] * x[c]
                        by_speed += s[j, c] * y[c]
                    out[0, i, k, j], out[1, i, k, j] = by_position, by_speed
                j = parent[j]
            p = parent[i]
            if p >= 0:
                mass[p] += mass[i]
                for r in range(3):
                    first[p, r] += first[i, r]
                    momentum[p, r] += momentum[i, r]
                    wrench[p, r] += wrench[i, r]
                    wrench[p, r + 3] += wrench[i, r + 3]
                    for c in range(3):
                        inertia[p, r, c] += inertia[i, r, c]
                        g[p, r, c] += g[i, r, c]


@numba.njit(cache=True, nogil=True)
def _place(angle, parent, fixed, offset, axis, prismatic, rot, at, turn, j):
    """Frame of link j in the base's."""
    for r in range(3):
        at[j, r] = offset[r]
    if prismatic:
        for r in range(3):
            for c in range(3):
                turn[r, c] = fixed[r, c]
                at[j, r] += fixed[r, c] * axis[c] * angle
    else:
        _joint_frame(fixed, axis, angle, turn)
    if parent < 0:
        rot[j] = turn
        return
    x, y, z = at[j]
    for r in range(3):
        up = rot[parent, r]
        at[j, r] = at[parent, r] + up[0] * x + up[1] * y + up[2] * z
        for c in range(3):
            rot[j, r, c] = up[0] * turn[0, c] + up[1] * turn[1, c] + up[2] * turn[2, c]


@numba.njit(cache=True, nogil=True)
def _axis(rot, at, axis, prismatic, out):
    """Motion that a joint's unit rate gives."""
    for r in range(3):
        along = rot[r, 0] * axis[0] + rot[r, 1] * axis[1] + rot[r, 2] * axis[2]
        out[r], out[r + 3] = (0.0, along) if prismatic else (along, 0.0)
    if not prismatic:
        _cross(at, out[:3], out[3:])


@numba.njit(cache=True, nogil=True)
def _weigh(h, rot, at, mass, first, inertia, j):
    """Mass, first moments and inertia of a link about the base's origin."""
    m = h[0]
    mass[j] = m
    px, py, pz = at
    for r in range(3):
        first[r] = rot[r, 0] * h[1] + rot[r, 1] * h[2] + rot[r, 2] * h[3]
    for r in range(3):
        x, y, z = rot[r]
        one = x * h[4] + y * h[5] + z * h[7]
        two = x * h[5] + y * h[6] + z * h[8]
        three = x * h[7] + y * h[8] + z * h[9]
        for c in range(3):
            inertia[r, c] = one * rot[c, 0] + two * rot[c, 1] + three * rot[c, 2]
    # parallel axes, in first moments: Σ (r·r - r rᵀ)dm with r = p + what lies in the link
    fx, fy, fz = first
    dot = m * (px * px + py * py + pz * pz) + 2.0 * (px * fx + py * fy + pz * fz)
    for r in range(3):
        inertia[r, r] += dot
        for c in range(3):
            inertia[r, c] -= m * at[r] * at[c] + at[r] * first[c] + first[r] * at[c]
    for r in range(3):
        first[r] += m * at[r]


@numba.njit(cache=True, nogil=True)
def _swing(v, mass, first, inertia, momentum, g):
    """P = Σ ṙ dm and G = Σ ṙ rᵀ dm of a moving link."""
    _cross(v[:3], first, momentum)
    half = 0.5 * (inertia[0, 0] + inertia[1, 1] + inertia[2, 2])
    for r in range(3):
        momentum[r] += mass * v[3 + r]
    wx, wy, wz = v[0], v[1], v[2]
    for c in range(3):
        # column c of Σ r rᵀ dm
        ex, ey, ez = -inertia[0, c], -inertia[1, c], -inertia[2, c]
        if c == 0:
            ex += half
        elif c == 1:
            ey += half
        else:
            ez += half
        g[0, c] = wy * ez - wz * ey + v[3] * first[c]
        g[1, c] = wz * ex - wx * ez + v[4] * first[c]
        g[2, c] = wx * ey - wy * ex + v[5] * first[c]


@numba.njit(cache=True, nogil=True)
def _times(mass, first, inertia, v, out):
    """Spatial momentum I·v."""
    fx, fy, fz = first
    a, b, c, x, y, z = v
    out[0] = inertia[0, 0] * a + inertia[0, 1] * b + inertia[0, 2] * c + fy * z - fz * y
    out[1] = inertia[1, 0] * a + inertia[1, 1] * b + inertia[1, 2] * c + fz * x - fx * z
    out[2] = inertia[2, 0] * a + inertia[2, 1] * b + inertia[2, 2] * c + fx * y - fy * x
    out[3] = mass * x - (fy * c - fz * b)
    out[4] = mass * y - (fz * a - fx * c)
    out[5] = mass * z - (fx * b - fy * a)


@numba.njit(cache=True, nogil=True)
def _doubled(g, p, x, out):
    """2·B·x."""
    trace = g[0, 0] + g[1, 1] + g[2, 2]
    a, b, c = x[0], x[1], x[2]
    for r in range(3):
        out[r] = 2.0 * (trace * x[r] - g[r, 0] * a - g[r, 1] * b - g[r, 2] * c)
    out[3] = 2.0 * (b * p[2] - c * p[1])
    out[4] = 2.0 * (c * p[0] - a * p[2])
    out[5] = 2.0 * (a * p[1] - b * p[0])


@numba.njit(cache=True, nogil=True)
def _leaning(g, p, x, out):
    """(2·B)ᵀ·x, its angular part: the linear one is zero."""
    trace = g[0, 0] + g[1, 1] + g[2, 2]
    a, b, c, d, e, f = x
    for r in range(3):
        out[r] = 2.0 * (trace * x[r] - g[0, r] * a - g[1, r] * b - g[2, r] * c)
    out[0] += 2.0 * (p[1] * f - p[2] * e)
    out[1] += 2.0 * (p[2] * d - p[0] * f)
    out[2] += 2.0 * (p[0] * e - p[1] * d)


@numba.njit(cache=True, nogil=True)
def _motion_cross(v, m, out):
    """v × m of two motions."""
    a, b, c, d, e, f = v
    r, s, t, x, y, z = m
    out[0], out[1], out[2] = b * t - c * s, c * r - a * t, a * s - b * r
    out[3] = b * z - c * y + e * t - f * s
    out[4] = c * x - a * z + f * r - d * t
    out[5] = a * y - b * x + d * s - e * r


@numba.njit(cache=True, nogil=True)
def _force_cross(v, w, out):
    """v ×* w of a motion and a wrench."""
    a, b, c, d, e, f = v
    r, s, t, x, y, z = w
    out[0] = b * t - c * s + e * z - f * y
    out[1] = c * r - a * t + f * x - d * z
    out[2] = a * s - b * r + d * y - e * x
    out[3], out[4], out[5] = b * z - c * y, c * x - a * z, a * y - b * x
