"""How an arm's torque changes where a joint sits, or its axis points, elsewhere than its URDF says,
or the ring that its angle is read from is not round about that axis.

What a joint's frame is off by shows in all joints: those before it carry its links elsewhere, those
behind it stand otherwise in gravity. A turn about the joint's own axis is a zero, and no matter of
geometry.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.dynamics.inverse import inverse_dynamics
from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]

STEP = 1e-5  # m or rad of a one-sided difference: half of a double's digits


@dataclass(frozen=True)
class Freedom:
    """What may be otherwise with a joint (0-based), as one thing to be measured.

    kind: its origin, along each axis of the link that carries it, m; its axis, turned about the
    two directions across it, rad; or its ring, by which the angle reads too high by sin(q) and
    cos(q), rad; along (3, k): these directions, or the identity (2, 2) of a ring
    """

    joint: int
    kind: Literal["origin", "axis", "ring"]
    along: Array

    def moved(self, robot: Robot, by: Array) -> Robot:
        """The arm with that frame elsewhere. by: (k,) m or rad."""
        to, j = self.along @ by, self.joint
        if self.kind == "origin":
            translation = robot.translation.copy()
            translation[j] += to
            return replace(robot, translation=translation)
        rotation = robot.rotation.copy()
        rotation[j] = rotation[j] @ scipy.spatial.transform.Rotation.from_rotvec(to).as_matrix()
        return replace(robot, rotation=rotation)

    def torque(self, robot: Robot, bodies: Array, motion: Sequence[Array]) -> Array:
        """(N, n, k) N·m per m or rad: derivative of the torque of bodies (n, 10) in a motion
        (q, dq, ddq), (N, n) each."""
        here = inverse_dynamics(robot, bodies, *motion)
        units = STEP * np.eye(self.along.shape[1])
        if self.kind == "ring":
            there = [inverse_dynamics(robot, bodies, *self.read(motion, unit)) for unit in units]
        else:
            there = [inverse_dynamics(self.moved(robot, unit), bodies, *motion) for unit in units]
        return np.stack([(one - here) / STEP for one in there], axis=-1)

    def read(self, motion: Sequence[Array], by: Array) -> list[Array]:
        """The motion (q, dq, ddq) behind one that such a ring reads, to first order. by: (2,)."""
        q, dq, ddq = (x.copy() for x in motion)
        turn, speed = motion[0][:, self.joint], motion[1][:, self.joint]
        error = by[0] * np.sin(turn) + by[1] * np.cos(turn)
        slope = by[0] * np.cos(turn) - by[1] * np.sin(turn)
        q[:, self.joint] -= error
        dq[:, self.joint] -= slope * speed
        ddq[:, self.joint] -= slope * motion[2][:, self.joint] - error * speed**2
        return [q, dq, ddq]


def freedoms(robot: Robot) -> Iterator[Freedom]:
    """Of all joints; where the first stands, and how, is no matter of the arm's own."""
    for j in range(robot.n):
        if not robot.prismatic[j]:
            yield Freedom(j, "ring", np.eye(2))
        if robot.parent[j] < 0:
            continue
        yield Freedom(j, "origin", np.eye(3))
        yield Freedom(j, "axis", np.linalg.svd(robot.axis[j][None])[2][1:].T)
