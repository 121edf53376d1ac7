"""Derivatives of the rigid bodies' torque by position, velocity and acceleration of every joint.

Closed form in one outward and one inward recursion, all joints at once, in the base's frame:
Singh, Russell & Wensing, Efficient Analytical Derivatives of Rigid-Body Dynamics using Spatial
Vector Algebra, IEEE RA-L 7 (2022). Their matrix 2·B of a body needs two sums over its mass only:
its momentum P and G = Σ ṙ·rᵀ·dm; with x = (ω, v) it is 2·B·x = (2(tr G - G)ω, 2 ω × P).
A joint of one freedom does not move its own axis: their Ψ̇ (the parent's velocity × s) is their Ṡ.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.lanes import LANES, arm, column, read_joint, turning
from pa10d.dynamics.regressor import _tree
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
    """LANES samples side by side: every helper is one loop over them that writes to one array,
    which the compiler turns into vector instructions (it gives up where more arrays might overlap).

    What belongs to the base stands behind the last joint's.
    """
    samples, n = q.shape
    turn, ahead = np.zeros((n, 3, 3, 3)), np.zeros((n, 3))
    mass, second = np.zeros(n), np.zeros((n, 6))
    for j in range(n):
        turning(fixed[j], axis[j], prismatic[j], turn[j], ahead[j])
        _second(h[j], second[j])
    for position in range(n - 1, -1, -1):
        j = order[position]
        mass[j] += h[j, 0]
        if parent[j] >= 0:
            mass[parent[j]] += mass[j]
    rot, at = np.empty((n + 1, 3, 3, LANES)), np.empty((n + 1, 3, LANES))  # rot[j, c]: column c
    # motions (angular, linear at the base's origin): axis, by how much it turns, by how much what
    # moving the joint does to its velocity turns, velocity, acceleration
    s, by_q = np.empty((n, 6, LANES)), np.empty((n, 6, LANES))
    by_q_rate = np.empty((n, 6, LANES))
    v, a = np.empty((n + 1, 6, LANES)), np.empty((n + 1, 6, LANES))
    # of all that joint i carries: first moments, inertia xx xy yy xz yz zz about the origin;
    # momentum (angular, linear), tr G - G by rows, wrench
    first, inertia = np.empty((n, 3, LANES)), np.empty((n, 6, LANES))
    momentum, g, wrench = np.empty((n, 6, LANES)), np.empty((n, 9, LANES)), np.empty((n, 6, LANES))
    joint, local, spread = np.empty((5, LANES)), np.empty((3, LANES)), np.empty((6, LANES))
    push, lean = np.empty((6, LANES)), np.empty((3, LANES))
    x, y, pair = np.empty((6, LANES)), np.empty((6, LANES)), np.empty((5, LANES))
    rot[n], at[n], v[n], a[n] = 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        rot[n, k, k] = 1.0
        a[n, k + 3] = -gravity[k]
    for start in range(0, samples, LANES):
        lanes = min(LANES, samples - start)
        for j in order:
            p = parent[j] if parent[j] >= 0 else n
            read_joint(q, dq, ddq, start, lanes, j, prismatic[j], joint)
            for c in range(3):
                column(turn[j, c], joint, lanes, local)
                _up(rot[p], local, lanes, rot[j, c])
            arm(offset[j], ahead[j], joint, lanes, local)
            _up(rot[p], local, lanes, at[j])
            _add(at[p], lanes, at[j])
            _axis(rot[j], at[j], axis[j], prismatic[j], lanes, s[j])
            _clear(lanes, by_q[j])
            _add_turned(v[p], s[j], lanes, by_q[j])
            _clear(lanes, by_q_rate[j])
            _add_turned(a[p], s[j], lanes, by_q_rate[j])
            _add_turned(v[p], by_q[j], lanes, by_q_rate[j])
            _velocity(v[p], s[j], joint, lanes, v[j])
            _acceleration(a[p], s[j], by_q[j], joint, lanes, a[j])
            _first(h[j], rot[j], lanes, first[j])
            _spread(h[j, 0], second[j], rot[j], at[j], first[j], lanes, spread)
            _inertia(spread, lanes, inertia[j])
            _moved(h[j, 0], at[j], lanes, first[j])
            _momentum(h[j, 0], first[j], inertia[j], v[j], lanes, momentum[j])
            _swing(spread, first[j], v[j], lanes, g[j])
            _momentum(h[j, 0], first[j], inertia[j], a[j], lanes, wrench[j])
            _add_force(v[j], momentum[j], lanes, wrench[j])
        for position in range(n - 1, -1, -1):
            i = order[position]
            _momentum(mass[i], first[i], inertia[i], s[i], lanes, push)  # sᵢᵀI
            _leaning(g[i], momentum[i], s[i], lanes, lean)  # sᵢᵀB, which sees angular rates only
            # what moving joint i does to the joints before it; y: half of it
            _momentum(mass[i], first[i], inertia[i], by_q_rate[i], lanes, x)
            _add_swung(2.0, g[i], momentum[i], by_q[i], lanes, x)
            _add_force(s[i], wrench[i], lanes, x)
            _momentum(mass[i], first[i], inertia[i], by_q[i], lanes, y)
            _add_swung(1.0, g[i], momentum[i], s[i], lanes, y)
            j = i
            while j >= 0:
                _pair(push, lean, x, y, s[j], by_q[j], by_q_rate[j], lanes, pair)
                _write(pair, start, lanes, i, j, out)
                j = parent[j]
            p = parent[i]
            if p >= 0:
                _add(first[i], lanes, first[p])
                _add(inertia[i], lanes, inertia[p])
                _add(momentum[i], lanes, momentum[p])
                _add(g[i], lanes, g[p])
                _add(wrench[i], lanes, wrench[p])


@numba.njit(cache=True, nogil=True)
def _second(h, out):
    """Σ r·rᵀ·dm of a link about its own frame, xx xy yy xz yz zz, from its inertia."""
    half = 0.5 * (h[4] + h[6] + h[9])
    for k in range(6):
        out[k] = -h[4 + k]
    out[0] += half
    out[2] += half
    out[5] += half


@numba.njit(cache=True, nogil=True)
def _up(rot, v, lanes, out):
    """A vector of a link's frame in the base's."""
    for k in range(lanes):
        x, y, z = v[0, k], v[1, k], v[2, k]
        out[0, k] = rot[0, 0, k] * x + rot[1, 0, k] * y + rot[2, 0, k] * z
        out[1, k] = rot[0, 1, k] * x + rot[1, 1, k] * y + rot[2, 1, k] * z
        out[2, k] = rot[0, 2, k] * x + rot[1, 2, k] * y + rot[2, 2, k] * z


@numba.njit(cache=True, nogil=True)
def _add(what, lanes, out):
    for r in range(len(what)):
        for k in range(lanes):
            out[r, k] += what[r, k]


@numba.njit(cache=True, nogil=True)
def _axis(rot, at, axis, prismatic, lanes, out):
    """Motion that a joint's unit rate gives."""
    u, v, w = axis
    for k in range(lanes):
        x = rot[0, 0, k] * u + rot[1, 0, k] * v + rot[2, 0, k] * w
        y = rot[0, 1, k] * u + rot[1, 1, k] * v + rot[2, 1, k] * w
        z = rot[0, 2, k] * u + rot[1, 2, k] * v + rot[2, 2, k] * w
        if prismatic:
            out[0, k], out[1, k], out[2, k] = 0.0, 0.0, 0.0
            out[3, k], out[4, k], out[5, k] = x, y, z
        else:
            out[0, k], out[1, k], out[2, k] = x, y, z
            out[3, k] = at[1, k] * z - at[2, k] * y
            out[4, k] = at[2, k] * x - at[0, k] * z
            out[5, k] = at[0, k] * y - at[1, k] * x


@numba.njit(cache=True, nogil=True)
def _clear(lanes, out):
    for r in range(len(out)):
        for k in range(lanes):
            out[r, k] = 0.0


@numba.njit(cache=True, nogil=True)
def _add_turned(v, m, lanes, out):
    """out += v × m of two motions."""
    for k in range(lanes):
        a, b, c, d, e, f = v[0, k], v[1, k], v[2, k], v[3, k], v[4, k], v[5, k]
        r, s, t, x, y, z = m[0, k], m[1, k], m[2, k], m[3, k], m[4, k], m[5, k]
        out[0, k] += b * t - c * s
        out[1, k] += c * r - a * t
        out[2, k] += a * s - b * r
        out[3, k] += b * z - c * y + e * t - f * s
        out[4, k] += c * x - a * z + f * r - d * t
        out[5, k] += a * y - b * x + d * s - e * r


@numba.njit(cache=True, nogil=True)
def _velocity(parent, s, joint, lanes, out):
    for r in range(6):
        for k in range(lanes):
            out[r, k] = parent[r, k] + s[r, k] * joint[3, k]


@numba.njit(cache=True, nogil=True)
def _acceleration(parent, s, by_q, joint, lanes, out):
    for r in range(6):
        for k in range(lanes):
            out[r, k] = parent[r, k] + s[r, k] * joint[4, k] + by_q[r, k] * joint[3, k]


@numba.njit(cache=True, nogil=True)
def _first(h, rot, lanes, out):
    """First moments of a link about its own origin, in the base's directions."""
    x, y, z = h[1], h[2], h[3]
    for k in range(lanes):
        out[0, k] = rot[0, 0, k] * x + rot[1, 0, k] * y + rot[2, 0, k] * z
        out[1, k] = rot[0, 1, k] * x + rot[1, 1, k] * y + rot[2, 1, k] * z
        out[2, k] = rot[0, 2, k] * x + rot[1, 2, k] * y + rot[2, 2, k] * z


@numba.njit(cache=True, nogil=True)
def _spread(mass, second, rot, at, first, lanes, out):
    """Σ r·rᵀ·dm of a link about the base's origin, xx xy yy xz yz zz."""
    xx, xy, yy, xz, yz, zz = second
    half = 0.5 * mass
    for k in range(lanes):
        a, b, c = rot[0, 0, k], rot[1, 0, k], rot[2, 0, k]
        d, e, f = rot[0, 1, k], rot[1, 1, k], rot[2, 1, k]
        g, i, j = rot[0, 2, k], rot[1, 2, k], rot[2, 2, k]
        ax, ay, az = a * xx + b * xy + c * xz, a * xy + b * yy + c * yz, a * xz + b * yz + c * zz
        dx, dy, dz = d * xx + e * xy + f * xz, d * xy + e * yy + f * yz, d * xz + e * yz + f * zz
        gx, gy, gz = g * xx + i * xy + j * xz, g * xy + i * yy + j * yz, g * xz + i * yz + j * zz
        # parallel axes, in first moments: r = p + what lies in the link
        px, py, pz = at[0, k], at[1, k], at[2, k]
        ux, uy, uz = first[0, k] + half * px, first[1, k] + half * py, first[2, k] + half * pz
        out[0, k] = ax * a + ay * b + az * c + 2.0 * ux * px
        out[1, k] = ax * d + ay * e + az * f + ux * py + uy * px
        out[2, k] = dx * d + dy * e + dz * f + 2.0 * uy * py
        out[3, k] = ax * g + ay * i + az * j + ux * pz + uz * px
        out[4, k] = dx * g + dy * i + dz * j + uy * pz + uz * py
        out[5, k] = gx * g + gy * i + gz * j + 2.0 * uz * pz


@numba.njit(cache=True, nogil=True)
def _inertia(spread, lanes, out):
    for k in range(lanes):
        xx, yy, zz = spread[0, k], spread[2, k], spread[5, k]
        out[0, k], out[2, k], out[5, k] = yy + zz, xx + zz, xx + yy
        out[1, k], out[3, k], out[4, k] = -spread[1, k], -spread[3, k], -spread[4, k]


@numba.njit(cache=True, nogil=True)
def _moved(mass, at, lanes, first):
    """First moments about the base's origin from those about the link's."""
    for r in range(3):
        for k in range(lanes):
            first[r, k] += mass * at[r, k]


@numba.njit(cache=True, nogil=True)
def _momentum(mass, first, inertia, v, lanes, out):
    """Spatial momentum I·v."""
    for k in range(lanes):
        fx, fy, fz = first[0, k], first[1, k], first[2, k]
        a, b, c, x, y, z = v[0, k], v[1, k], v[2, k], v[3, k], v[4, k], v[5, k]
        xy, xz, yz = inertia[1, k], inertia[3, k], inertia[4, k]
        out[0, k] = inertia[0, k] * a + xy * b + xz * c + fy * z - fz * y
        out[1, k] = xy * a + inertia[2, k] * b + yz * c + fz * x - fx * z
        out[2, k] = xz * a + yz * b + inertia[5, k] * c + fx * y - fy * x
        out[3, k] = mass * x - (fy * c - fz * b)
        out[4, k] = mass * y - (fz * a - fx * c)
        out[5, k] = mass * z - (fx * b - fy * a)


@numba.njit(cache=True, nogil=True)
def _swing(spread, first, v, lanes, out):
    """tr G - G, by rows, with G = Σ ṙ·rᵀ·dm of a moving link."""
    for k in range(lanes):
        wx, wy, wz = v[0, k], v[1, k], v[2, k]
        a, b, c = v[3, k], v[4, k], v[5, k]
        fx, fy, fz = first[0, k], first[1, k], first[2, k]
        xx, xy, yy = spread[0, k], spread[1, k], spread[2, k]
        xz, yz, zz = spread[3, k], spread[4, k], spread[5, k]
        g00 = wy * xz - wz * xy + a * fx
        g11 = wz * xy - wx * yz + b * fy
        g22 = wx * yz - wy * xz + c * fz
        out[0, k], out[4, k], out[8, k] = g11 + g22, g00 + g22, g00 + g11
        out[1, k] = wz * yy - wy * yz - a * fy
        out[2, k] = wz * yz - wy * zz - a * fz
        out[3, k] = wx * xz - wz * xx - b * fx
        out[5, k] = wx * zz - wz * xz - b * fz
        out[6, k] = wy * xx - wx * xy - c * fx
        out[7, k] = wy * xy - wx * yy - c * fy


@numba.njit(cache=True, nogil=True)
def _add_swung(times, g, momentum, x, lanes, out):
    """out += times·B·x."""
    for k in range(lanes):
        a, b, c = times * x[0, k], times * x[1, k], times * x[2, k]
        p, q, r = momentum[3, k], momentum[4, k], momentum[5, k]
        out[0, k] += g[0, k] * a + g[1, k] * b + g[2, k] * c
        out[1, k] += g[3, k] * a + g[4, k] * b + g[5, k] * c
        out[2, k] += g[6, k] * a + g[7, k] * b + g[8, k] * c
        out[3, k] += b * r - c * q
        out[4, k] += c * p - a * r
        out[5, k] += a * q - b * p


@numba.njit(cache=True, nogil=True)
def _leaning(g, momentum, x, lanes, out):
    """Bᵀ·x, its angular part: the linear one is zero."""
    for k in range(lanes):
        a, b, c, d, e, f = x[0, k], x[1, k], x[2, k], x[3, k], x[4, k], x[5, k]
        p, q, r = momentum[3, k], momentum[4, k], momentum[5, k]
        out[0, k] = g[0, k] * a + g[3, k] * b + g[6, k] * c + q * f - r * e
        out[1, k] = g[1, k] * a + g[4, k] * b + g[7, k] * c + r * d - p * f
        out[2, k] = g[2, k] * a + g[5, k] * b + g[8, k] * c + p * e - q * d


@numba.njit(cache=True, nogil=True)
def _add_force(v, w, lanes, out):
    """out += v ×* w of a motion and a wrench."""
    for k in range(lanes):
        a, b, c, d, e, f = v[0, k], v[1, k], v[2, k], v[3, k], v[4, k], v[5, k]
        r, s, t, x, y, z = w[0, k], w[1, k], w[2, k], w[3, k], w[4, k], w[5, k]
        out[0, k] += b * t - c * s + e * z - f * y
        out[1, k] += c * r - a * t + f * x - d * z
        out[2, k] += a * s - b * r + d * y - e * x
        out[3, k] += b * z - c * y
        out[4, k] += c * x - a * z
        out[5, k] += a * y - b * x


@numba.njit(cache=True, nogil=True)
def _pair(push, lean, x, y, s, by_q, by_q_rate, lanes, out):
    """Joints i and j, which carries it: torque of i by position, speed and acceleration of j, of j
    by position and speed of i."""
    for k in range(lanes):
        position, speed, acceleration, back, back_speed = 0.0, 0.0, 0.0, 0.0, 0.0
        for c in range(6):
            position += push[c, k] * by_q_rate[c, k]
            speed += push[c, k] * by_q[c, k]
            acceleration += push[c, k] * s[c, k]
            back += x[c, k] * s[c, k]
            back_speed += y[c, k] * s[c, k]
        for c in range(3):
            position += 2.0 * lean[c, k] * by_q[c, k]
            speed += lean[c, k] * s[c, k]
        out[0, k], out[1, k], out[2, k] = position, 2.0 * speed, acceleration
        out[3, k], out[4, k] = back, 2.0 * back_speed


@numba.njit(cache=True, nogil=True)
def _write(pair, start, lanes, i, j, out):
    for k in range(lanes):
        out[0, j, start + k, i], out[1, j, start + k, i] = pair[0, k], pair[1, k]
        out[2, j, start + k, i] = out[2, i, start + k, j] = pair[2, k]
    if i != j:
        for k in range(lanes):
            out[0, i, start + k, j], out[1, i, start + k, j] = pair[3, k], pair[4, k]
