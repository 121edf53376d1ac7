"""Gains of the joint servo by a stated rule.

With inertia J and no other dynamics, PID puts three poles of the closed loop at -ω where
kp = 3·J·ω², ki = J·ω³, kd = 3·J·ω; ω = 2π times the profile's ``bandwidth_hz``, which by
itself is 4 Hz, and less in proportion where the loop is slower than 500 Hz. The loop stays
stable up to nine times this inertia. It does not far below it: there kd/J outruns the delay of
the bus and of the speed's filter. So J is the median of M_jj over poses drawn within the limits,
but at most ``ABOVE_LIGHTEST`` times what the joint moves in its lightest pose, all other joints
giving way: on the PA10 the third joint of a stretched arm moves a quarter of its median, and
swings up at 47 Hz if its gains are made for that. Bodies are the URDF's, plus a rotor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.profile import Control

Array = NDArray[np.float64]

POSES = 256
ABOVE_LIGHTEST = 1.5  # leaves 4 dB until the loop's delay of 4 ms makes it unstable
ROTOR = 0.75 / 232.0**1.75  # kg·m² per N·m^1.75: PA10's first axes, scaled by the torque limit


@dataclass(frozen=True)
class PidGains:
    """(n,) each: N·m/rad, N·m/(rad·s), N·m·s/rad."""

    kp: Array
    ki: Array
    kd: Array


def nominal_inertia(robot: Robot) -> Array:
    """(n,) kg·m² that the gains are made for, with a rotor of usual size."""
    mass = mass_matrices(robot)
    median = np.median(np.diagonal(mass, axis1=1, axis2=2), axis=0)
    lightest = np.min(1.0 / np.diagonal(np.linalg.inv(mass), axis1=1, axis2=2), axis=0)
    return np.minimum(median, ABOVE_LIGHTEST * lightest)


def mass_matrices(robot: Robot) -> Array:
    """(POSES, n, n) kg·m² in poses drawn within the limits, with rotors."""
    weightless = robot.with_gravity(np.zeros(3))
    rng = np.random.default_rng(0)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    q = rng.uniform(lower, upper, (POSES, robot.n))
    still = np.zeros_like(q)
    links = [
        inverse_dynamics(weightless, robot.parameters, q, still, np.broadcast_to(unit, q.shape))
        for unit in np.eye(robot.n)
    ]
    rotor = ROTOR * np.where(np.isfinite(robot.effort), robot.effort, 0.0) ** 1.75
    return np.stack(links, axis=2) + np.diag(rotor)


def pid_gains(robot: Robot, control: Control) -> PidGains:
    """From the profile where it has them, else by the rule."""
    inertia, w = nominal_inertia(robot), 2.0 * np.pi * control.servo_bandwidth
    given = control.gains

    def chosen(values: list[float] | None, rule: Array) -> Array:
        return rule if values is None else np.array(values, dtype=float)

    return PidGains(
        kp=chosen(given.kp, 3.0 * inertia * w**2),
        ki=chosen(given.ki, inertia * w**3),
        kd=chosen(given.kd, 3.0 * inertia * w),
    )
