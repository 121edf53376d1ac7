"""A simulated pendulum: the truth behind a weighing is known."""

from __future__ import annotations

import numpy as np

from pa10d.dynamics import robot_from_urdf
from pa10d.identify.scale import Body
from pa10d.measurement.recording import Recording

PENDULUM = robot_from_urdf(
    """<robot name="pendulum"><link name="base"/><link name="arm"/>
<joint name="j1" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="5"/></joint></robot>"""
)
EXACT = Body(1.434, (0.0, 0.0, -0.5), 0.0, (0.0, 0.0, 0.0))
RATE = 50.0
T = np.arange(0.0, 24.0, 1 / RATE)
Q = 0.8 * np.sin(0.5 * np.pi * T) + 0.5 * np.cos(0.9 * np.pi * T)


def carried(body: Body, q):
    """N·m that a slow pendulum holds, by Newton."""
    _, _, z = body.com
    return -9.80665 * body.mass * z * np.sin(q)


def swing(name: str, gain: float, noise: float, seed: int, body=EXACT, driving=0.0, driven=0.0):
    """One recording: the weight's own torque, friction that goes with it, noise."""
    dq = np.gradient(Q, T)
    load = carried(body, Q) + body.mass * body.com[2] ** 2 * np.gradient(dq, T)
    lifts = load * dq > 0
    rub = np.where(lifts, driving, driven) * np.abs(load) * np.sign(dq)
    tau = gain * (load + rub) + np.random.default_rng(seed).normal(0.0, noise, len(T))
    return Recording(name, T, Q[:, None], tau[:, None])
