"""Rigid bodies with NumPy alone, under the names that ``pa10d.dynamics`` has for them.

Kept free of the package: exports carry this file's text. Written for reading and for any
number type, which is why it also works out its own derivatives and can be traced.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Robot:
    """A tree of n joints, as in the profile's URDF: parent and order (n,), rotation (n, 3, 3) and
    translation (n, 3) of each joint's frame in its parent's, axis (n, 3), prismatic (n,),
    gravity (3,) m/s², typical (n,) kg·m² that each joint moves in its usual poses."""

    parent: np.ndarray
    order: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    axis: np.ndarray
    prismatic: np.ndarray
    gravity: np.ndarray
    typical: np.ndarray

    @property
    def n(self):
        """Number of joints."""
        return len(self.parent)

    def with_gravity(self, gravity):
        """The same arm under another gravity."""
        return replace(self, gravity=np.asarray(gravity, dtype=float))


def typical_inertia(robot, parameters):
    """(n,) kg·m²: the usual value of each joint's own inertia."""
    return robot.typical


def inverse_dynamics(robot, parameters, q, dq, ddq):
    """Newton-Euler torque (N, n) of standard parameters (n, 10)."""
    n, samples = robot.n, len(q)
    turn, arm, w, dw, a, force, moment, out = ([np.zeros(0)] * n for _ in range(8))
    still = np.zeros((samples, 3))
    for j in robot.order:
        p, axis, fixed = robot.parent[j], robot.axis[j], robot.rotation[j]
        sliding = robot.prismatic[j]
        offset = robot.translation[j] + still
        wp, dwp = (w[p], dw[p]) if p >= 0 else (still, still)
        ap = a[p] if p >= 0 else still - robot.gravity
        turn[j] = fixed + np.zeros((samples, 3, 3)) if sliding else fixed @ about(axis, q[:, j])
        arm[j] = offset + q[:, j, None] * (fixed @ axis) if sliding else offset
        moved = ap + cross(dwp, arm[j]) + cross(wp, cross(wp, arm[j]))
        w[j], dw[j], a[j] = (down(turn[j], v) for v in (wp, dwp, moved))
        rate, push = dq[:, j, None] * axis, ddq[:, j, None] * axis
        if sliding:
            a[j] = a[j] + 2.0 * cross(w[j], rate) + push
        else:
            dw[j] = dw[j] + cross(w[j], rate) + push
            w[j] = w[j] + rate
    for j in range(n):
        m, first = parameters[j, 0], parameters[j, 1:4]
        inertia = parameters[j, [4, 5, 7, 5, 6, 8, 7, 8, 9]].reshape(3, 3)
        force[j] = m * a[j] + cross(dw[j], first) + cross(w[j], cross(w[j], first))
        moment[j] = dw[j] @ inertia + cross(w[j], w[j] @ inertia) + cross(first, a[j])
    for j in reversed(robot.order):
        out[j] = (force[j] if robot.prismatic[j] else moment[j]) @ robot.axis[j]
        p = robot.parent[j]
        if p >= 0:
            f = (turn[j] @ force[j][:, :, None])[:, :, 0]
            force[p] = force[p] + f
            moment[p] = moment[p] + (turn[j] @ moment[j][:, :, None])[:, :, 0] + cross(arm[j], f)
    return np.stack(out, axis=1)


def regressor(robot, q, dq, ddq, columns):
    """Torque (N, n, k) per unit of the standard parameters of these numbers, 10 to a link."""
    units = np.eye(10 * robot.n)[columns].reshape(-1, robot.n, 10)
    return np.stack([inverse_dynamics(robot, one, q, dq, ddq) for one in units], axis=-1)


def sensitivities(robot, parameters, q, dq, ddq):
    """∂τ/∂q_j, ∂τ/∂q̇_j and ∂τ/∂q̈_j (n, N, n) each, by complex steps: exact to the last digit."""
    step, n = 1e-30, robot.n
    turned = np.eye(3 * n).reshape(3, n, 3, 1, n)  # by what, by which joint, of what
    moved = np.stack([q, dq, ddq]) + 1j * step * turned
    rows = [moved[:, :, k].reshape(-1, n) for k in range(3)]
    found = inverse_dynamics(robot, parameters, *rows).imag / step
    return tuple(found.reshape(3, n, len(q), n))


def about(axis, angle):
    """Rotations (N, 3, 3) about a unit vector by angles (N,)."""
    x, y, z = axis
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * k + (1.0 - c) * (k @ k)


def down(turn, v):
    """From the parent's frame into the child's."""
    return (v[:, None, :] @ turn)[:, 0, :]


def cross(a, b):
    """Products of vectors (…, 3)."""
    (ax, ay, az), (bx, by, bz) = np.moveaxis(a, -1, 0), np.moveaxis(b, -1, 0)
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)
