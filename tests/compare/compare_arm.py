"""A three-joint arm with a known model, and recordings of it with a known error on top."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pa10d.dynamics import base_parameters, robot_from_urdf
from pa10d.measurement.recording import Recording
from pa10d.model import Term, TorqueModel

LINK = """<link name="l{k}"><inertial><origin xyz="0.02 0.01 0.2"/><mass value="{m}"/>
<inertia ixx="0.2" ixy="0.01" ixz="0" iyy="0.25" iyz="0.02" izz="0.1"/></inertial></link>"""
JOINT = """<joint name="j{k}" type="revolute"><parent link="l{p}"/><child link="l{k}"/>
<origin xyz="0 0 0.3" rpy="{r} 0 0"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="100" velocity="3"/></joint>"""
URDF = (
    '<robot name="three"><link name="l0"/>'
    + "".join(LINK.format(k=k, m=4 - k) for k in (1, 2, 3))
    + "".join(JOINT.format(k=k, p=k - 1, r=r) for k, r in ((1, 0), (2, 1.5707963), (3, -1.2)))
    + "</robot>"
)
ROBOT = robot_from_urdf(URDF)
RATE, CUTOFF = 250.0, 10.0


def model() -> TorqueModel:
    """The truth: the URDF's rigid bodies and textbook friction."""
    base = base_parameters(ROBOT)
    terms = [
        Term(kind, (j,), np.array([value]), {"v0": 0.02} if kind == "coulomb" else {})
        for kind, value in (("rotor_inertia", 0.3), ("coulomb", 2.0), ("viscous", 1.5))
        for j in range(3)
    ]
    size = len(base) + len(terms)
    return TorqueModel(
        name="truth",
        robot=ROBOT,
        base=base,
        h=base.of(ROBOT.parameters),
        terms=tuple(terms),
        covariance=np.eye(size) * 1e-4,
        noise=np.full(3, 0.1),
        cutoff=CUTOFF,
    )


Extra = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def recording(
    seed: int = 0,
    seconds: float = 40.0,
    noise: float = 0.2,
    extra: Extra | None = None,
    name: str = "run",
    coloured: float = 0.0,
    period: float | None = None,
    later: float = 0.0,
    noise_seed: int | None = None,
) -> Recording:
    """Sums of sines that never repeat, or do after ``period`` s, begun ``later`` s into the motion.

    extra(t, q, dq) -> (N, 3) N·m on top of the model; coloured: a first-order low-pass's pole on
    the noise; noise_seed: for other noise on the same motion
    """
    rng = np.random.default_rng(seed)
    t = np.arange(int(seconds * RATE)) / RATE
    omega = rng.uniform(0.4, 3.5, (3, 5))
    if period is not None:
        omega = np.ceil(omega * period / (2 * np.pi)) * (2 * np.pi / period)
    size = rng.uniform(0.2, 0.7, (3, 5)) / omega
    phase = rng.uniform(0, 2 * np.pi, (3, 5))
    angle = omega[None] * (t[:, None, None] + later) + phase[None]
    q = np.sum(size * np.sin(angle), axis=2)
    dq = np.sum(size * omega * np.cos(angle), axis=2)
    drawn = rng if noise_seed is None else np.random.default_rng(noise_seed)
    white = drawn.standard_normal((len(t), 3))
    if coloured:
        import scipy.signal

        gain = np.sqrt(1 - coloured**2)
        white = scipy.signal.lfilter([gain], [1, -coloured], white, axis=0)
    silent = Recording(name, t, q, np.zeros_like(q))
    from pa10d.regression.equation import prepare

    tau = model().predict(prepare(silent, ROBOT, CUTOFF).context) + noise * white
    if extra is not None:
        tau = tau + extra(t, q, dq)
    return Recording(name, t, q, tau)


def on_joint(joint: int, values: np.ndarray) -> np.ndarray:
    """(N,) on one joint (0-based), nothing on the others."""
    out = np.zeros((len(values), 3))
    out[:, joint] = values
    return out
