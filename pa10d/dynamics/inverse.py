"""Torque of the rigid bodies: the Newton-Euler recursion, many samples side by side.

Khalil & Dombre, *Modeling, Identification and Control of Robots*, ch. 9; every quantity in its own
link's frame, where a link's parameters do not depend on the pose.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.lanes import LANES, arm, column, read_joint, turning
from pa10d.dynamics.regressor import _tree
from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]


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


@numba.njit(cache=True, nogil=True)
def _torque(q, dq, ddq, parent, order, fixed, offset, axis, prismatic, gravity, h, out):
    """Outwards the motion of every link and the wrench that it needs, inwards the sum of those.

    What belongs to the base stands behind the last joint's.
    """
    samples, n = q.shape
    # no wider than what is asked: a single sample lies close together
    width = min(LANES, samples)
    turn, ahead = np.empty((n, 3, 3, 3)), np.empty((n, 3))
    for j in range(n):
        turning(fixed[j], axis[j], prismatic[j], turn[j], ahead[j])
    rot, at = np.empty((n, 3, 3, width)), np.empty((n, 3, width))  # rot[j, c]: column c
    # angular rate and acceleration, acceleration of the origin; force, moment about the origin
    motion, wrench = np.empty((n + 1, 9, width)), np.empty((n, 6, width))
    joint, carried = np.empty((5, width)), np.empty((3, width))
    motion[n] = 0.0
    for k in range(3):
        motion[n, k + 6] = -gravity[k]
    for start in range(0, samples, LANES):
        lanes = min(LANES, samples - start)
        for j in order:
            p = parent[j] if parent[j] >= 0 else n
            read_joint(q, dq, ddq, start, lanes, j, prismatic[j], joint)
            for c in range(3):
                column(turn[j, c], joint, lanes, rot[j, c])
            arm(offset[j], ahead[j], joint, lanes, at[j])
            _carried(motion[p], at[j], lanes, carried)
            _link(motion[p], rot[j], carried, joint, axis[j], prismatic[j], lanes, motion[j])
            _wrench(h[j], motion[j], lanes, wrench[j])
        for position in range(n - 1, -1, -1):
            j = order[position]
            _write(axis[j], prismatic[j], wrench[j], start, lanes, j, out)
            if parent[j] >= 0:
                _hand_on(rot[j], at[j], wrench[j], lanes, wrench[parent[j]])


@numba.njit(cache=True, nogil=True)
def _carried(motion, at, lanes, out):
    """Acceleration of a point at rest in a moving link, in the link's frame."""
    for k in range(lanes):
        x, y, z = motion[0, k], motion[1, k], motion[2, k]
        u, v, w = motion[3, k], motion[4, k], motion[5, k]
        a, b, c = at[0, k], at[1, k], at[2, k]
        d, e, f = y * c - z * b, z * a - x * c, x * b - y * a  # ω × r
        out[0, k] = motion[6, k] + v * c - w * b + y * f - z * e
        out[1, k] = motion[7, k] + w * a - u * c + z * d - x * f
        out[2, k] = motion[8, k] + u * b - v * a + x * e - y * d


@numba.njit(cache=True, nogil=True)
def _link(parent, rot, carried, joint, axis, prismatic, lanes, out):
    """A link's motion from its parent's and its own joint's."""
    a, b, c = axis[0], axis[1], axis[2]
    for k in range(lanes):
        r00, r10, r20 = rot[0, 0, k], rot[0, 1, k], rot[0, 2, k]
        r01, r11, r21 = rot[1, 0, k], rot[1, 1, k], rot[1, 2, k]
        r02, r12, r22 = rot[2, 0, k], rot[2, 1, k], rot[2, 2, k]
        rate, push = joint[3, k], joint[4, k]
        x, y, z = parent[0, k], parent[1, k], parent[2, k]
        wx = r00 * x + r10 * y + r20 * z
        wy = r01 * x + r11 * y + r21 * z
        wz = r02 * x + r12 * y + r22 * z
        x, y, z = parent[3, k], parent[4, k], parent[5, k]
        ux = r00 * x + r10 * y + r20 * z
        uy = r01 * x + r11 * y + r21 * z
        uz = r02 * x + r12 * y + r22 * z
        x, y, z = carried[0, k], carried[1, k], carried[2, k]
        ax = r00 * x + r10 * y + r20 * z
        ay = r01 * x + r11 * y + r21 * z
        az = r02 * x + r12 * y + r22 * z
        dx, dy, dz = wy * c - wz * b, wz * a - wx * c, wx * b - wy * a  # ω × axis
        if prismatic:
            out[0, k], out[1, k], out[2, k] = wx, wy, wz
            out[3, k], out[4, k], out[5, k] = ux, uy, uz
            out[6, k] = ax + 2.0 * rate * dx + push * a
            out[7, k] = ay + 2.0 * rate * dy + push * b
            out[8, k] = az + 2.0 * rate * dz + push * c
        else:
            out[0, k], out[1, k], out[2, k] = wx + rate * a, wy + rate * b, wz + rate * c
            out[3, k] = ux + rate * dx + push * a
            out[4, k] = uy + rate * dy + push * b
            out[5, k] = uz + rate * dz + push * c
            out[6, k], out[7, k], out[8, k] = ax, ay, az


@numba.njit(cache=True, nogil=True)
def _wrench(h, motion, lanes, out):
    """Force on a link and moment about its origin that its motion needs."""
    mass, a, b, c = h[0], h[1], h[2], h[3]
    xx, xy, yy, xz, yz, zz = h[4], h[5], h[6], h[7], h[8], h[9]
    for k in range(lanes):
        x, y, z = motion[0, k], motion[1, k], motion[2, k]
        u, v, w = motion[3, k], motion[4, k], motion[5, k]
        r, s, t = motion[6, k], motion[7, k], motion[8, k]
        d, e, f = y * c - z * b, z * a - x * c, x * b - y * a  # ω × first moments
        out[0, k] = mass * r + v * c - w * b + y * f - z * e
        out[1, k] = mass * s + w * a - u * c + z * d - x * f
        out[2, k] = mass * t + u * b - v * a + x * e - y * d
        d = xx * x + xy * y + xz * z
        e = xy * x + yy * y + yz * z
        f = xz * x + yz * y + zz * z
        out[3, k] = xx * u + xy * v + xz * w + y * f - z * e + b * t - c * s
        out[4, k] = xy * u + yy * v + yz * w + z * d - x * f + c * r - a * t
        out[5, k] = xz * u + yz * v + zz * w + x * e - y * d + a * s - b * r


@numba.njit(cache=True, nogil=True)
def _write(axis, prismatic, wrench, start, lanes, j, out):
    """Torque of a joint, force of a slide: what goes along its axis."""
    first = 0 if prismatic else 3
    a, b, c = axis[0], axis[1], axis[2]
    for k in range(lanes):
        out[start + k, j] = (
            a * wrench[first, k] + b * wrench[first + 1, k] + c * wrench[first + 2, k]
        )


@numba.njit(cache=True, nogil=True)
def _hand_on(rot, at, wrench, lanes, out):
    """out += a link's wrench, in its parent's frame and about the parent's origin."""
    for k in range(lanes):
        r00, r10, r20 = rot[0, 0, k], rot[0, 1, k], rot[0, 2, k]
        r01, r11, r21 = rot[1, 0, k], rot[1, 1, k], rot[1, 2, k]
        r02, r12, r22 = rot[2, 0, k], rot[2, 1, k], rot[2, 2, k]
        a, b, c = at[0, k], at[1, k], at[2, k]
        x, y, z = wrench[0, k], wrench[1, k], wrench[2, k]
        fx = r00 * x + r01 * y + r02 * z
        fy = r10 * x + r11 * y + r12 * z
        fz = r20 * x + r21 * y + r22 * z
        x, y, z = wrench[3, k], wrench[4, k], wrench[5, k]
        out[0, k] += fx
        out[1, k] += fy
        out[2, k] += fz
        out[3, k] += r00 * x + r01 * y + r02 * z + b * fz - c * fy
        out[4, k] += r10 * x + r11 * y + r12 * z + c * fx - a * fz
        out[5, k] += r20 * x + r21 * y + r22 * z + a * fy - b * fx
