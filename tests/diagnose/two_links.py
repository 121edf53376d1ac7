"""A planar arm of two joints whose torque is known in closed form: small and fast."""

from __future__ import annotations

from functools import cache

import numpy as np

from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.dynamics import Robot, inverse_dynamics, robot_from_urdf
from pa10d.effects.base import smooth_sign
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel

RATE = 200.0
SECONDS = 30.0
CUTOFF = 8.0
V0 = 0.01
ROTOR, COULOMB, VISCOUS = np.array([0.4, 0.2]), np.array([2.0, 1.0]), np.array([3.0, 1.5])
NAMES = ("fit_a", "fit_b", "valid_a", "valid_b")

URDF = """<robot name="two"><link name="base"/>
<joint name="a" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l1"><inertial><mass value="4"/><origin xyz="0.05 0 0.2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="b" type="revolute"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/>
<origin xyz="0 0 0.4"/><limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l2"><inertial><mass value="2"/><origin xyz="0.02 0 0.15"/>
<inertia ixx="0.03" iyy="0.03" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


@cache
def robot() -> Robot:
    """Both links hang in a vertical plane."""
    return robot_from_urdf(URDF)


def motion(seed: int, seconds: float = SECONDS):
    """t (N,), q, q̇, q̈ (N, 2): sums of sines, derivatives in closed form."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * RATE)) / RATE
    w = 2 * np.pi * rng.uniform(0.08, 0.9, (6, 2))
    a = rng.uniform(0.2, 0.5, (6, 2)) / w**0.5
    angle = w[None] * t[:, None, None] + rng.uniform(0, 2 * np.pi, (6, 2))
    return (
        t,
        (a * np.sin(angle)).sum(axis=1),
        (a * w * np.cos(angle)).sum(axis=1),
        -(a * w**2 * np.sin(angle)).sum(axis=1),
    )


def textbook_torque(q, dq, ddq) -> np.ndarray:
    """(N, 2) N·m of rigid bodies, rotors, Coulomb and viscous friction."""
    rigid = inverse_dynamics(robot(), robot().parameters, q, dq, ddq)
    sign = np.column_stack([smooth_sign(v, V0) for v in dq.T])
    return rigid + ROTOR * ddq + COULOMB * sign + VISCOUS * dq


def recordings(seed: int = 0, extra=None, noise: float = 0.05, colour=None) -> dict[str, Recording]:
    """Four runs. extra(t, q, dq, ddq) -> (N, 2) more torque; colour(rng, N) -> (N,) noise."""
    out = {}
    for number, name in enumerate(NAMES):
        rng = np.random.default_rng([seed, number, 7])
        t, q, dq, ddq = motion(100 * seed + number)
        tau = textbook_torque(q, dq, ddq)
        if extra is not None:
            tau = tau + extra(t, q, dq, ddq)
        make = colour or (lambda rng, samples: rng.standard_normal(samples))
        tau = tau + noise * np.column_stack([make(rng, len(t)) for _ in range(2)])
        out[name] = Recording(name, t, q, tau)
    return out


def textbook(runs: dict[str, Recording], cutoff: float = CUTOFF) -> TorqueModel:
    """Identified from the two runs to fit."""
    return identify([runs["fit_a"], runs["fit_b"]], robot(), name="m0", cutoff=cutoff)


def state_of(
    runs: dict[str, Recording], model: TorqueModel | None = None, **options
) -> SearchState:
    """The textbook model fitted to two runs, judged on the other two."""
    model = model or textbook(runs)
    train, held, _ = two_sides(
        model, [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )
    return SearchState.start(model, train, held, **options)
