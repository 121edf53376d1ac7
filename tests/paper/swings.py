"""One joint that swings, with friction written down here."""

from __future__ import annotations

import numpy as np

from pa10d.dynamics import Robot, robot_from_urdf
from pa10d.measurement.recording import Recording

RATE = 500.0
INERTIA, COULOMB, VISCOUS = 0.7, 8.0, 10.0


def pendulum(mass: float = 0.0, axis: str = "0 1 0") -> Robot:
    """A link with its mass 0.4 m out; axis y: gravity acts."""
    return robot_from_urdf(
        '<robot name="p"><link name="base"/><joint name="j" type="revolute"><parent link="base"/>'
        f'<child link="l"/><axis xyz="{axis}"/>'
        '<limit lower="-3" upper="3" velocity="1" effort="99"/></joint>'
        '<link name="l"><inertial><origin xyz="0 0 0.4"/>'
        f'<mass value="{max(mass, 1e-3)}"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" '
        'iyz="0"/></inertial></link></robot>'
    )


def sine(peak: float, period: float, cycles: int, centre: float = 0.1):
    """t, q, dq, ddq of a sine with this peak speed."""
    t = np.arange(round(period * cycles * RATE) + 1) / RATE
    omega = 2 * np.pi / period
    angle = omega * t + 0.4
    size = peak / omega
    return t, centre + size * np.sin(angle), peak * np.cos(angle), -peak * omega * np.sin(angle)


def stribeck(rise: float, speed: float):
    """Extra friction that is gone above some multiple of ``speed``."""
    return lambda t, q, dq: rise * np.exp(-((dq / speed) ** 2)) * np.sign(dq)


def bristles(stiffness: float):
    """Dahl's friction instead of Coulomb's: what it adds to that."""

    def extra(t, q, dq):
        z = np.zeros(len(t))
        for k in range(1, len(t)):  # exact for constant speed over a sample
            step = q[k] - q[k - 1]
            limit = np.sign(step) * COULOMB
            z[k] = limit + (z[k - 1] - limit) * np.exp(-stiffness * abs(step) / COULOMB)
        return z - COULOMB * np.sign(dq)

    return extra


def swings(extra=None, noise=0.3, seed=0, gravity=0.0, peak=0.9, cycles=(10, 4)):
    """Fast and slow sines of one joint as recordings; gravity: N·m at q = 90°."""
    rng = np.random.default_rng(seed)
    found = []
    for name, period, count in (("fast", 4.0, cycles[0]), ("slow", 16.0, cycles[1])):
        t, q, dq, ddq = sine(peak * 4.0 / period, period, count)
        tau = INERTIA * ddq + COULOMB * np.sign(dq) + VISCOUS * dq - gravity * np.sin(q)
        if extra is not None:
            tau = tau + extra(t, q, dq)
        tau = tau + noise * rng.normal(size=len(t))
        found.append(Recording(name, t, q[:, None], tau[:, None]))
    return found
