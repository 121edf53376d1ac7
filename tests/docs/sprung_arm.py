"""Files such as a user has: two joints, a spring on the second that no textbook has, noise."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from pa10d.dynamics import inverse_dynamics, robot_from_urdf

URDF = """<robot name="two"><link name="base"/>
<joint name="a" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l1"><inertial><mass value="3"/><origin xyz="0.04 0 0.2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="b" type="revolute"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/>
<origin xyz="0 0 0.4"/><limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l2"><inertial><mass value="2"/><origin xyz="0.02 0 0.15"/>
<inertia ixx="0.03" iyy="0.03" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
STIFF = 6.0  # N·m/rad: a spring at the second joint that no textbook model has
RATE, SECONDS, NOISE = 200.0, 20.0, 0.05


def recording(path: Path, seed: int) -> None:
    """A motion of its own for each seed."""
    rng = np.random.default_rng(seed)
    robot = robot_from_urdf(URDF)
    t = np.arange(round(SECONDS * RATE)) / RATE
    w = 2 * np.pi * rng.uniform(0.08, 0.9, (6, 2))
    a, phase = rng.uniform(0.1, 0.3, (6, 2)), rng.uniform(0, 2 * np.pi, (6, 2))
    angle = w[None] * t[:, None, None] + phase
    q = (a * np.sin(angle)).sum(axis=1)
    dq = (a * w * np.cos(angle)).sum(axis=1)
    ddq = -(a * w**2 * np.sin(angle)).sum(axis=1)
    tau = inverse_dynamics(robot, robot.parameters, q, dq, ddq) + 0.3 * ddq
    tau += 1.5 * np.tanh(dq / 0.01) + 2.0 * dq + rng.normal(0, NOISE, q.shape)
    tau[:, 1] += STIFF * q[:, 1]
    with path.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["time", "q1", "q2", "tau1", "tau2"])
        out.writerows(np.column_stack([t, q, tau]).tolist())
