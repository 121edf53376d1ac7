"""Gains of the joint servo by a stated rule.

With inertia J and no other dynamics, PID puts three poles of the closed loop at -ω where
kp = 3·J·ω², ki = J·ω³, kd = 3·J·ω. J is the median of M_jj over poses drawn within the limits, of
the URDF's bodies plus a rotor. The loop stays stable up to nine times this inertia. ω = 2π times
the profile's ``bandwidth_hz``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.profile import Control

Array = NDArray[np.float64]

POSES = 64
ROTOR = 0.75 / 232.0**1.75  # kg·m² per N·m^1.75: PA10's first axes, scaled by the torque limit


@dataclass(frozen=True)
class PidGains:
    """(n,) each: N·m/rad, N·m/(rad·s), N·m·s/rad."""

    kp: Array
    ki: Array
    kd: Array


def nominal_inertia(robot: Robot) -> Array:
    """(n,) kg·m² that each joint moves: median over poses, plus a rotor of usual size."""
    weightless = robot.with_gravity(np.zeros(3))
    rng = np.random.default_rng(0)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    q = rng.uniform(lower, upper, (POSES, robot.n))
    still = np.zeros_like(q)
    out = np.empty(robot.n)
    for j in range(robot.n):
        unit = still.copy()
        unit[:, j] = 1.0
        m = inverse_dynamics(weightless, robot.parameters, q, still, unit)[:, j]
        out[j] = np.median(m)
    return out + ROTOR * np.where(np.isfinite(robot.effort), robot.effort, 0.0) ** 1.75


def pid_gains(robot: Robot, control: Control) -> PidGains:
    """From the profile where it has them, else by the rule."""
    inertia, w = nominal_inertia(robot), 2.0 * np.pi * control.bandwidth_hz
    given = control.gains

    def chosen(values: list[float] | None, rule: Array) -> Array:
        return rule if values is None else np.array(values, dtype=float)

    return PidGains(
        kp=chosen(given.kp, 3.0 * inertia * w**2),
        ki=chosen(given.ki, inertia * w**3),
        kd=chosen(given.kd, 3.0 * inertia * w),
    )
