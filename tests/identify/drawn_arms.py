"""Arms drawn at random, upright on a turning base, whose bodies, rotors and friction can exist."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pa10d.dynamics import Robot, inverse_dynamics, robot_from_urdf
from pa10d.dynamics.robot import rigid_body

AXES = "zyyxyxz"
AS_TOLD = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]


@dataclass(frozen=True)
class Arm:
    """robot: as a URDF has it, 30 % off; bodies (n, 10), rotor, coulomb, viscous (n,): in truth."""

    robot: Robot
    bodies: np.ndarray
    rotor: np.ndarray
    coulomb: np.ndarray
    viscous: np.ndarray

    def torque(self, q, dq, ddq, v0=0.01):
        rubbing = self.coulomb * np.tanh(dq / v0) + self.viscous * dq
        rigid = inverse_dynamics(self.robot, self.bodies, q, dq, ddq)
        return rigid + self.rotor * ddq + rubbing


def drawn(joints: int, seed: int) -> Arm:
    """The shoulder's rotor weighs as much as what it moves, as behind a gear."""
    rng = np.random.default_rng(seed)
    length = rng.uniform(0.15, 0.4, joints)
    links, true = [], []
    for k in range(joints):
        mass = 12.0 * 0.6**k
        com = np.append(rng.normal(0, 0.02, 2), 0.5 * length[k])
        a, b, c = np.array([0.09, 0.09, length[k]]) * rng.uniform(0.7, 1.3, 3)
        moments = np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) * mass / 12
        turn, _ = np.linalg.qr(np.eye(3) + 0.15 * rng.normal(size=(3, 3)))
        tensor = turn @ moments @ turn.T
        links.append((mass, com, tensor))
        other = rng.uniform(0.7, 1.3, 5)
        true.append(rigid_body(mass * other[0], com * other[1:4], other[4] * tensor[AS_TOLD]))
    robot = robot_from_urdf(_urdf(length, links))
    size = 0.5 ** np.arange(joints)
    rotor, coulomb, viscous = rng.uniform(0.5, 1.5, (3, joints)) * size * [[2.0], [8.0], [6.0]]
    return Arm(robot, np.array(true), rotor, coulomb, viscous)


def _urdf(length, links) -> str:
    parts = ['<robot name="drawn"><link name="l0"/>']
    for k, (mass, com, inertia) in enumerate(links, start=1):
        axis = " ".join(str(int(AXES[k - 1] == which)) for which in "xyz")
        names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        values = zip(names, inertia[AS_TOLD], strict=True)
        tensor = " ".join(f'{name}="{float(value)!r}"' for name, value in values)
        above = float(length[k - 2]) if k > 1 else 0.2
        parts.append(
            f'<link name="l{k}"><inertial><origin xyz="{" ".join(map(str, com))}"/>'
            f'<mass value="{mass!r}"/><inertia {tensor}/></inertial></link>'
            f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
            f'<origin xyz="0 {0.08 * (k % 2)} {above!r}"/><axis xyz="{axis}"/>'
            '<limit lower="-3" upper="3" effort="200" velocity="5"/></joint>'
        )
    return "".join([*parts, "</robot>"])
