"""Two links in a plane behind motors that move as they are told, the second on a spring: links in
closed form, whatever their springs are wound to when the recorder is started."""

from __future__ import annotations

import itertools
import math

import numpy as np
import scipy
from two_links import COULOMB, NAMES, ROTOR, V0, VISCOUS, motion, robot

from pa10d.dynamics import inverse_dynamics
from pa10d.effects.base import smooth_sign
from pa10d.measurement.recording import Recording

SECONDS = 20.0
NOISE = 0.05
LINK, OFFSET, MASS, ARM = (
    0.03 + 2.0 * (0.02**2 + 0.15**2),
    0.4,
    2.0,
    (0.02, 0.15),
)  # URDF of robot()
GRAVITY = 9.81


def spring_of(mode: float, zeta: float) -> tuple[float, float]:
    """K N·m/rad and C N·m·s/rad of a mode in Hz, the motor held."""
    omega = 2.0 * np.pi * mode
    return LINK * omega**2, 2.0 * zeta * LINK * omega


def recordings(stiffness: float, damping: float, seed: int) -> dict[str, Recording]:
    """The second joint's spring is not wound at all as each run begins."""
    return {n: _run(n, stiffness, damping, 10 * seed + k) for k, n in enumerate(NAMES)}


def _run(name: str, stiffness: float, damping: float, seed: int) -> Recording:
    t, q, dq, ddq = motion(seed, SECONDS)
    link = [x.copy() for x in (q, dq, ddq)]
    link[0][:, 1], link[1][:, 1] = _followed(t, (q, dq, ddq), stiffness, damping)
    passes = stiffness * (q - link[0])[:, 1] + damping * (dq - link[1])[:, 1]
    first = (x[:, 0] for x in (q, dq, ddq))
    link[2][:, 1] = _accelerates(passes, *first, link[0][:, 1], np)
    load = inverse_dynamics(robot(), robot().parameters, *link)
    np.testing.assert_allclose(load[:, 1], passes, atol=1e-6 * np.abs(passes).max())
    sign = np.column_stack([smooth_sign(v, V0) for v in dq.T])
    tau = load + ROTOR * ddq + COULOMB * sign + VISCOUS * dq
    noise = NOISE * np.random.default_rng(seed).standard_normal(tau.shape)
    return Recording(name, t, q, tau + noise)


def _followed(t, motor, stiffness: float, damping: float):
    """(2, N) rad and rad/s of the second link: Runge and Kutta's fourth order, the motors' motion
    between samples from its derivatives."""
    h = t[1] - t[0]
    between = [
        scipy.interpolate.CubicHermiteSpline(t, x, v)(t[:-1] + 0.5 * h)
        for x, v in itertools.pairwise(motor)
    ]
    between.append(scipy.interpolate.CubicSpline(t, motor[2])(t[:-1] + 0.5 * h))
    on, mid = np.hstack(motor).tolist(), np.hstack(between).tolist()

    def rate(m, x, v):
        passes = stiffness * (m[1] - x) + damping * (m[3] - v)
        return v, _accelerates(passes, m[0], m[2], m[4], x, math)

    out = np.zeros((2, len(t)))
    x, v = out[:, 0] = on[0][1], on[0][3]
    for k, middle in enumerate(mid):
        x1, v1 = rate(on[k], x, v)
        x2, v2 = rate(middle, x + 0.5 * h * x1, v + 0.5 * h * v1)
        x3, v3 = rate(middle, x + 0.5 * h * x2, v + 0.5 * h * v2)
        x4, v4 = rate(on[k + 1], x + h * x3, v + h * v3)
        x += h / 6.0 * (x1 + 2.0 * x2 + 2.0 * x3 + x4)
        v += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4)
        out[:, k + 1] = x, v
    return out


def _accelerates(passes, first, speed, gathers, angle, of):
    """rad/s² of the second link against the first, driven by N·m about its axis; of: whose sines,
    those of numbers (math) or of arrays (numpy)."""
    x, z = ARM
    turned = first + angle
    across = OFFSET * (gathers * of.cos(first) - speed**2 * of.sin(first))  # of its axis, m/s²
    along = OFFSET * (-gathers * of.sin(first) - speed**2 * of.cos(first)) + GRAVITY
    reach_x = x * of.cos(turned) + z * of.sin(turned)
    reach_z = -x * of.sin(turned) + z * of.cos(turned)
    return (passes - MASS * (reach_z * across - reach_x * along)) / LINK - gathers
