"""The gradient of any scalar of the torque regressor with respect to the motion.

For weights G the sum L = Σ G·Y(q, q̇, q̈) has gradients in q, q̇ and q̈ of every sample. One sweep
outwards repeats the regressor's recursion, one sweep inwards carries the adjoints back; a bar
marks the derivative of L with respect to a quantity. It costs about three regressors, whatever the
number of joints, and lets an optimiser follow singular values of observation matrices.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.regressor import _joint_frame, _tree
from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]

_ROW = np.array([0, 0, 1, 0, 1, 2])  # Ixx Ixy Iyy Ixz Iyz Izz as places in the tensor
_COLUMN = np.array([0, 1, 1, 2, 2, 2])


def regressor_gradient(
    robot: Robot,
    q: Array,
    dq: Array,
    ddq: Array,
    weights: Array,
    columns: NDArray[np.int64] | None = None,
) -> tuple[Array, Array, Array]:
    """∂L/∂q, ∂L/∂q̇, ∂L/∂q̈, each (N, n), of L = Σ weights·regressor(robot, q, dq, ddq, columns).

    weights: (N, n, k) as the regressor; columns: (k,) indices into the standard parameters.
    """
    n = robot.n
    chosen = np.arange(10 * n) if columns is None else np.asarray(columns, dtype=np.int64)
    full = np.zeros((len(q), n, 10 * n))
    full[:, :, chosen] = weights
    grad_q, grad_dq, grad_ddq = (np.zeros((len(q), n)) for _ in range(3))
    _back(
        np.ascontiguousarray(q, dtype=float),
        np.ascontiguousarray(dq, dtype=float),
        np.ascontiguousarray(ddq, dtype=float),
        *_tree(robot),
        full,
        grad_q,
        grad_dq,
        grad_ddq,
    )
    return grad_q, grad_dq, grad_ddq


@numba.njit(cache=True)
def _cross(a, b, out):
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@numba.njit(cache=True)
def _down(rot, v, out):
    """out = rotᵀ v: from the parent's frame into the child's."""
    for k in range(3):
        out[k] = rot[0, k] * v[0] + rot[1, k] * v[1] + rot[2, k] * v[2]


@numba.njit(cache=True)
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


@numba.njit(cache=True)
def _add_cross(a, b, out):
    out[0] += a[1] * b[2] - a[2] * b[1]
    out[1] += a[2] * b[0] - a[0] * b[2]
    out[2] += a[0] * b[1] - a[1] * b[0]


@numba.njit(cache=True)
def _add_up(rot, v, out):
    """out += rot v: from the child's frame into the parent's."""
    for k in range(3):
        out[k] += rot[k, 0] * v[0] + rot[k, 1] * v[1] + rot[k, 2] * v[2]


@numba.njit(cache=True)
def _triple(a, b, c):
    """a · (b × c)."""
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


@numba.njit(cache=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@numba.njit(cache=True)
def _link(g, i_to, parent, w, dw, a, spin, shift, w_, dw_, a_, spin_, shift_, t):
    """Adjoints that the body of link j itself causes; g (n, 10) are its weights."""
    for c in range(10):
        t[0:2, :] = 0.0  # angular and linear rate of the link if the joints ran at g[:, c]
        i = i_to
        seen = False
        while i >= 0:
            if g[i, c] != 0.0:
                seen = True
                for k in range(3):
                    t[0, k] += g[i, c] * spin[i, k]
                    t[1, k] += g[i, c] * shift[i, k]
            i = parent[i]
        if not seen:
            continue
        p, h = t[0], t[1]
        moment, force, unit, turned = t[2], t[3], t[4], t[5]
        moment[:] = 0.0
        force[:] = 0.0
        if c == 0:
            for k in range(3):
                force[k] = a[k]
                a_[k] += h[k]
        elif c < 4:
            unit[:] = 0.0
            unit[c - 1] = 1.0
            _cross(w, unit, turned)
            _cross(w, turned, force)
            _add_cross(dw, unit, force)
            _cross(unit, a, moment)
            _add_cross(p, unit, a_)
            _add_cross(unit, h, dw_)
            _add_cross(turned, h, w_)
            _cross(h, w, turned)
            _add_cross(unit, turned, w_)
        else:
            x, y = _ROW[c - 4], _COLUMN[c - 4]
            unit[:] = 0.0  # E w, with E the tensor that has a one at (x, y) and (y, x)
            unit[x] = w[y]
            unit[y] = w[x]
            _cross(w, unit, moment)
            _add_cross(unit, p, w_)
            _cross(p, w, turned)
            w_[x] += turned[y]
            dw_[x] += p[y]
            moment[x] += dw[y]
            if x != y:
                w_[y] += turned[x]
                dw_[y] += p[x]
                moment[y] += dw[x]
        i = i_to
        while i >= 0:
            if g[i, c] != 0.0:
                for k in range(3):
                    spin_[i, k] += g[i, c] * moment[k]
                    shift_[i, k] += g[i, c] * force[k]
            i = parent[i]


@numba.njit(cache=True)
def _back(
    q, dq, ddq, parent, order, fixed, offset, axis, prismatic, gravity,
    weights, grad_q, grad_dq, grad_ddq,
):  # fmt: skip
    samples, n = q.shape
    rot, arm = np.empty((n, 3, 3)), np.empty((n, 3))
    w, dw, a = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    spin, shift = np.empty((n, n, 3)), np.empty((n, n, 3))
    w_, dw_, a_ = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    spin_, shift_ = np.empty((n, n, 3)), np.empty((n, n, 3))
    g, t, zero = np.empty((n, 10)), np.empty((10, 3)), np.zeros(3)
    for s in range(samples):
        _motion(
            q[s], dq[s], ddq[s], parent, order, fixed, offset, axis, prismatic, gravity,
            rot, arm, w, dw, a,
        )  # fmt: skip
        for part in (w_, dw_, a_):
            part[:] = 0.0
        spin_[:] = 0.0
        shift_[:] = 0.0
        for j in order:
            p, i = parent[j], parent[j]
            while i >= 0:
                _cross(spin[p, i], arm[j], t[0])
                for k in range(3):
                    t[0, k] += shift[p, i, k]
                _down(rot[j], t[0], shift[j, i])
                _down(rot[j], spin[p, i], spin[j, i])
                i = parent[i]
            for k in range(3):
                spin[j, j, k] = 0.0 if prismatic[j] else axis[j, k]
                shift[j, j, k] = axis[j, k] if prismatic[j] else 0.0
        for position in range(n - 1, -1, -1):
            j = order[position]
            g[:] = weights[s, :, 10 * j : 10 * j + 10]
            _link(
                g, j, parent, w[j], dw[j], a[j], spin[j], shift[j],
                w_[j], dw_[j], a_[j], spin_[j], shift_[j], t,
            )  # fmt: skip
            p = parent[j]
            wp = w[p] if p >= 0 else zero
            dwp = dw[p] if p >= 0 else zero
            z = axis[j]
            # what reached frame j through the joint: y = rotᵀ(parent's), its adjoint stays in place
            free_w, free_dw, free_a, free_dw_ = t[0], t[1], t[2], t[3]
            _down(rot[j], wp, free_w)
            if prismatic[j]:
                grad_ddq[s, j] = _dot(a_[j], z)
                grad_dq[s, j] = 2.0 * _triple(a_[j], w[j], z)
                for k in range(3):
                    t[4, k] = 2.0 * dq[s, j] * a_[j, k]
                _add_cross(z, t[4], w_[j])
            else:
                grad_ddq[s, j] = _dot(dw_[j], z)
                grad_dq[s, j] = _dot(w_[j], z) + _triple(dw_[j], free_w, z)
                for k in range(3):
                    free_dw_[k] = dq[s, j] * dw_[j, k]
                _add_cross(z, free_dw_, w_[j])
                # turning the joint turns every y: dy = -z × y dq
                _down(rot[j], dwp, free_dw)
                for k in range(3):
                    free_a[k] = a[j, k]
                total = (
                    _triple(z, w_[j], free_w)
                    + _triple(z, dw_[j], free_dw)
                    + _triple(z, a_[j], free_a)
                )
                i = p
                while i >= 0:
                    total += _triple(z, spin_[j, i], spin[j, i])
                    total += _triple(z, shift_[j, i], shift[j, i])
                    i = parent[i]
                grad_q[s, j] = total
            # hand the adjoints to the parent
            x_, arm_, turned = t[4], t[5], t[6]
            x_[:] = 0.0
            arm_[:] = 0.0
            _add_up(rot[j], a_[j], x_)
            _cross(wp, arm[j], turned)
            _add_cross(x_, dwp, arm_)
            if p >= 0:
                for k in range(3):
                    a_[p, k] += x_[k]
                _add_up(rot[j], w_[j], w_[p])
                _add_up(rot[j], dw_[j], dw_[p])
                _add_cross(arm[j], x_, dw_[p])
                _add_cross(turned, x_, w_[p])
            _cross(x_, wp, turned)
            _add_cross(turned, wp, arm_)
            if p >= 0:
                _add_cross(arm[j], turned, w_[p])
            i = p
            while i >= 0:
                turned[:] = 0.0
                _add_up(rot[j], shift_[j, i], turned)
                for k in range(3):
                    shift_[p, i, k] += turned[k]
                _add_up(rot[j], spin_[j, i], spin_[p, i])
                _add_cross(arm[j], turned, spin_[p, i])
                _add_cross(turned, spin[p, i], arm_)
                i = parent[i]
            if prismatic[j]:
                turned[:] = 0.0
                _add_up(fixed[j], z, turned)
                grad_q[s, j] = _dot(arm_, turned)
