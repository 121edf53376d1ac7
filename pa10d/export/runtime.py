"""Torque of a model from plain data, with NumPy alone.

Kept free of the package: exports carry this file's text along with a model's numbers.
"""

from __future__ import annotations

import numpy as np


def predict(model, q, dq, ddq, series=False):
    """Torque (N, n) for q, dq, ddq (N, n); series: rows follow one another in time."""
    gravity, rigid = np.array(model["gravity"]), np.array(model["rigid"])
    load = rigid_torque(model, rigid, q, dq, ddq, gravity)
    motion = Motion(model, q, dq, ddq, load, series)
    mechanics = load.copy()
    for term in model["terms"]:
        if term["effect"] not in SENSING:
            mechanics = mechanics + MECHANICS[term["effect"]](motion, term)
    measured = mechanics.copy()
    for term in model["terms"]:
        if term["effect"] in SENSING:
            j = term["joints"][0]
            measured[:, j] += SENSING[term["effect"]](mechanics[:, j], term)
    return measured


class Motion:
    """What effects look at."""

    def __init__(self, model, q, dq, ddq, load, series):
        self.model, self.q, self.dq, self.ddq, self.load = model, q, dq, ddq, load
        self.series = series

    def sign(self, v, v0):
        """sign(v) smoothed over v0; in a series its mean over each sample's interval."""
        if not self.series:
            return np.tanh(v / v0)
        middle = 0.5 * (v[1:] + v[:-1])
        before = np.concatenate([v[:1], middle])
        after = np.concatenate([middle, v[-1:]])
        span = after - before
        small = np.abs(span) < 1e-3 * v0
        rise = log_cosh(after / v0) - log_cosh(before / v0)
        return np.where(small, np.tanh(v / v0), v0 * rise / np.where(small, 1.0, span))

    def rigid(self, q):
        """Link-side torque at other positions."""
        gravity = np.array(self.model["gravity"])
        return rigid_torque(
            self.model, np.array(self.model["rigid"]), q, self.dq, self.ddq, gravity
        )


def log_cosh(x):
    """ln cosh x without overflow."""
    a = np.abs(x)
    return a + np.log1p(np.exp(-2.0 * a)) - np.log(2.0)


def rigid_torque(model, h, q, dq, ddq, gravity):
    """Newton-Euler torque (N, n) of standard parameters h (n, 10), gravity (3,) m/s²."""
    n, samples = len(model["parent"]), len(q)
    axes = np.array(model["axis"])
    empty = np.zeros((0, 3))
    turn, arm, w, dw, a, force, moment = ([empty] * n for _ in range(7))
    for j in model["order"]:
        p, axis, fixed = model["parent"][j], axes[j], np.array(model["rotation"][j])
        sliding = model["prismatic"][j]
        offset = np.broadcast_to(np.array(model["translation"][j]), (samples, 3))
        still = np.zeros((samples, 3))
        wp, dwp = (w[p], dw[p]) if p >= 0 else (still, still)
        ap = a[p] if p >= 0 else still - gravity
        turn[j] = (
            np.broadcast_to(fixed, (samples, 3, 3)) if sliding else fixed @ about(axis, q[:, j])
        )
        arm[j] = offset + q[:, j, None] * (fixed @ axis) if sliding else offset
        moved = ap + np.cross(dwp, arm[j]) + np.cross(wp, np.cross(wp, arm[j]))
        w[j], dw[j], a[j] = (down(turn[j], v) for v in (wp, dwp, moved))
        rate, push = dq[:, j, None] * axis, ddq[:, j, None] * axis
        if sliding:
            a[j] = a[j] + 2.0 * np.cross(w[j], rate) + push
        else:
            dw[j] = dw[j] + np.cross(w[j], rate) + push
            w[j] = w[j] + rate
    out = np.zeros((samples, n))
    for j in range(n):
        m, mc = h[j, 0], h[j, 1:4]
        inertia = h[j, [4, 5, 7, 5, 6, 8, 7, 8, 9]].reshape(3, 3)
        force[j] = m * a[j] + np.cross(dw[j], mc) + np.cross(w[j], np.cross(w[j], mc))
        moment[j] = dw[j] @ inertia + np.cross(w[j], w[j] @ inertia) + np.cross(mc, a[j])
    for j in reversed(model["order"]):
        out[:, j] = (force[j] if model["prismatic"][j] else moment[j]) @ axes[j]
        p = model["parent"][j]
        if p >= 0:
            f = np.einsum("nij,nj->ni", turn[j], force[j])
            force[p] = force[p] + f
            moment[p] = moment[p] + np.einsum("nij,nj->ni", turn[j], moment[j])
            moment[p] = moment[p] + np.cross(arm[j], f)
    return out


def about(axis, angle):
    """Rotations (N, 3, 3) about a unit vector by angles (N,)."""
    x, y, z = axis
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * k + (1.0 - c) * (k @ k)


def down(turn, v):
    """From the parent's frame into the child's."""
    return np.einsum("nji,nj->ni", turn, v)


def on(motion, joint, torque):
    """(N,) on one joint."""
    out = np.zeros_like(motion.q)
    out[:, joint] = torque
    return out


def own(formula):
    """An effect within one joint: formula(motion, joint, coefficients, shape) -> (N,)."""
    return lambda motion, term: on(
        motion,
        term["joints"][0],
        formula(motion, term["joints"][0], term["coefficients"], term["shape"]),
    )


def bell(x):
    return np.exp(-0.5 * x**2)


def coupling_friction(motion, term):
    """Friction on dq_i ± dq_j."""
    (i, j), (f, d), ratio = term["joints"], term["coefficients"], term["shape"]["ratio"]
    v = motion.dq[:, i] + ratio * motion.dq[:, j]
    torque = f * motion.sign(v, 1e-3) + d * v
    return on(motion, i, torque) + on(motion, j, ratio * torque)


def coupling_inertia(motion, term):
    """Inertia shared by two joints."""
    (i, j), (inertia,) = term["joints"], term["coefficients"]
    return on(motion, i, inertia * motion.ddq[:, j]) + on(motion, j, inertia * motion.ddq[:, i])


def payload(motion, term):
    """A body on the last link."""
    h = np.zeros_like(np.array(motion.model["rigid"]))
    h[-1, : len(term["coefficients"])] = term["coefficients"]
    gravity = np.array(motion.model["gravity"])
    return rigid_torque(motion.model, h, motion.q, motion.dq, motion.ddq, gravity)


def base_tilt(motion, term):
    """Gravity from another direction; turns: change of gravity per radian about x and y."""
    zero, out = np.zeros_like(motion.q), np.zeros_like(motion.q)
    rigid = np.array(motion.model["rigid"])
    for angle, turned in zip(term["coefficients"][:2], term["turns"], strict=True):
        direction = np.array(turned)
        out = out + angle * rigid_torque(motion.model, rigid, motion.q, zero, zero, direction)
    if term["vertical_first"]:
        j = motion.model["order"][0]
        cos, sin = term["coefficients"][2:4]
        out = out + on(motion, j, cos * np.cos(motion.q[:, j]) + sin * np.sin(motion.q[:, j]))
    return out


def encoder_offset(motion, term):
    """A joint's zero is elsewhere; at: offset about which the torque is linear."""
    j, (offset,), at = term["joints"][0], term["coefficients"], term["shape"].get("at", 0.0)
    step = np.zeros(motion.q.shape[1])
    if abs(at) < 1e-3:
        step[j] = 1e-4
        return -offset * (motion.rigid(motion.q + step) - motion.rigid(motion.q - step)) / 2e-4
    step[j] = at
    return offset * (motion.rigid(motion.q - step) - motion.load) / at


MECHANICS = {
    "rotor_inertia": own(lambda m, j, c, s: c[0] * m.ddq[:, j]),
    "coulomb": own(lambda m, j, c, s: c[0] * m.sign(m.dq[:, j], s["v0"])),
    "viscous": own(lambda m, j, c, s: c[0] * m.dq[:, j]),
    "torque_offset": own(lambda m, j, c, s: c[0]),
    "coulomb_asymmetry": own(lambda m, j, c, s: c[0] + c[1] * np.abs(m.dq[:, j])),
    "stribeck": own(
        lambda m, j, c, s: (
            c[0]
            * np.exp(-((np.abs(m.dq[:, j]) / s["vs"]) ** s["delta"]))
            * m.sign(m.dq[:, j], 0.05 * s["vs"])
        )
    ),
    "nonlinear_viscous": own(
        lambda m, j, c, s: c[0] * np.abs(m.dq[:, j]) ** s["p"] * np.sign(m.dq[:, j])
    ),
    "load_friction": own(
        lambda m, j, c, s: (
            c[0]
            * np.abs(m.load[:, j] - s.get("rotor", 0.0) * m.ddq[:, j])
            * m.sign(m.dq[:, j], s["v0"])
        )
    ),
    "position_friction": own(
        lambda m, j, c, s: (
            c[0]
            * (np.cos if s["wave"] else bell)((m.q[:, j] - s["qc"]) / s["w"])
            * m.sign(m.dq[:, j], 0.01)
        )
    ),
    "torque_ripple": own(
        lambda m, j, c, s: c[0] * np.sin(s["N"] * m.q[:, j]) + c[1] * np.cos(s["N"] * m.q[:, j])
    ),
    "spring": own(lambda m, j, c, s: c[0] * m.q[:, j] - c[1]),
    "contact": own(
        lambda m, j, c, s: c[0] * s["side"] * np.maximum(0.0, s["side"] * (m.q[:, j] - s["qs"]))
    ),
    "coupling_friction": coupling_friction,
    "coupling_inertia": coupling_inertia,
    "payload": payload,
    "base_tilt": base_tilt,
    "encoder_offset": encoder_offset,
}

SENSING = {
    "torque_gain": lambda torque, term: term["coefficients"][0] * torque,
    "torque_saturation": lambda torque, term: term["coefficients"][0] * torque**3,
}
