"""A light arm of six fast joints, recorded for seconds only: 6 s to fit, 3 s to judge by."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from pa10d.dynamics import Robot, inverse_dynamics, robot_from_urdf
from pa10d.effects.base import smooth_sign
from pa10d.measurement.recording import Recording

RATE = 500.0
NOISE = 0.005  # of the limits, standard deviation
LIMITS = np.array([60.0, 60.0, 40.0, 10.0, 10.0, 6.0])  # N·m
ROTOR = np.array([0.5, 0.5, 0.3, 0.08, 0.08, 0.05])
COULOMB = np.array([4.0, 5.0, 3.0, 0.8, 0.7, 0.5])
VISCOUS = np.array([3.0, 3.0, 2.0, 0.4, 0.4, 0.3])
LINKS = (  # mass kg, centre of mass, joint's place before it, axis
    (3.7, (0.0, -0.02, 0.0), (0, 0, 0.09), "0 0 1"),
    (8.4, (0.21, 0.0, 0.11), (0, 0.0, 0), "0 1 0"),
    (2.3, (0.18, 0.0, 0.02), (0.42, 0, 0), "0 1 0"),
    (1.2, (0.0, 0.02, 0.01), (0.39, 0, 0), "0 1 0"),
    (1.2, (0.01, 0.0, -0.02), (0, 0.1, 0), "0 0 -1"),
    (0.6, (0.01, 0.0, 0.03), (0, 0, -0.09), "0 1 0"),
)


@cache
def robot() -> Robot:
    """Six revolute joints, some 1 m of reach."""
    parts = ['<robot name="six"><link name="l0"/>']
    for i, (mass, com, place, axis) in enumerate(LINKS, start=1):
        size = 0.4 * mass * 0.08**2
        parts.append(
            f'<link name="l{i}"><inertial><mass value="{mass}"/>'
            f'<origin xyz="{com[0]} {com[1]} {com[2]}"/><inertia ixx="{size}" iyy="{1.3 * size}" '
            f'izz="{0.8 * size}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="j{i}" type="revolute"><parent link="l{i - 1}"/><child link="l{i}"/>'
            f'<origin xyz="{place[0]} {place[1]} {place[2]}"/><axis xyz="{axis}"/>'
            f'<limit lower="-3" upper="3" effort="{LIMITS[i - 1]}" velocity="4"/></joint>'
        )
    return robot_from_urdf("".join([*parts, "</robot>"]))


def motion(seed: int, seconds: float, pace: float = 1.0):
    """t (N,), q, q̇, q̈ (N, 6): six sines of 2 to 5 Hz per joint, 2 to 3 rad/s fast, so that a
    joint turns round every 0.14 s."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * RATE)) / RATE
    w = 2 * np.pi * pace * rng.uniform(2.0, 5.0, (6, 6))
    a = rng.uniform(0.5, 1.0, (6, 6)) / w
    angle = w[None] * t[:, None, None] + rng.uniform(0, 2 * np.pi, (6, 6))
    return (
        t,
        (a * np.sin(angle)).sum(axis=1),
        (a * w * np.cos(angle)).sum(axis=1),
        -(a * w**2 * np.sin(angle)).sum(axis=1),
    )


Extra = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def recording(
    name: str, seed: int, seconds: float, extra: Extra | None = None, pace: float = 1.0
) -> Recording:
    """One run; extra(q, q̇, q̈, rigid) -> (N, 6) N·m beside the textbook; pace: of its sines."""
    t, q, dq, ddq = motion(seed, seconds, pace)
    rng = np.random.default_rng([seed, 1])
    rigid = inverse_dynamics(robot(), robot().parameters, q, dq, ddq)
    sign = np.column_stack([smooth_sign(v, 0.005) for v in dq.T])
    tau = rigid + ROTOR * ddq + COULOMB * sign + VISCOUS * dq
    if extra is not None:
        tau = tau + extra(q, dq, ddq, rigid)
    tau = tau + NOISE * LIMITS * rng.standard_normal(q.shape)
    return Recording(name, t, q + 1e-5 * rng.standard_normal(q.shape), tau)


def two_runs(seed: int, extra: Extra | None = None) -> tuple[Recording, Recording]:
    """6 s to fit, 3 s of another motion to judge by."""
    return recording("fit", 2 * seed, 6.0, extra), recording("judge", 2 * seed + 1, 3.0, extra)
