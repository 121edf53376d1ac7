"""How an arm's torque changes where a joint sits, or its axis points, elsewhere than its URDF says.

What a joint's frame is off by shows in all joints: those before it carry its links elsewhere, those
behind it stand otherwise in gravity. A turn about the joint's own axis is a zero, and no matter of
geometry.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pa10d.dynamics.regressor import inverse_dynamics
from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]

STEP = 1e-5  # m or rad of a one-sided difference: half of a double's digits


@dataclass(frozen=True)
class Freedom:
    """A joint's frame (0-based) that may be elsewhere, as one thing to be measured.

    kind: its origin, along each axis of the link that carries it, m; or its axis, turned about the
    two directions across it, rad; along (3, k): these directions
    """

    joint: int
    kind: Literal["origin", "axis"]
    along: Array

    def moved(self, robot: Robot, by: Array) -> Robot:
        """The arm with that frame elsewhere. by: (k,) m or rad."""
        to, j = self.along @ by, self.joint
        if self.kind == "origin":
            translation = robot.translation.copy()
            translation[j] += to
            return replace(robot, translation=translation)
        rotation = robot.rotation.copy()
        rotation[j] = rotation[j] @ Rotation.from_rotvec(to).as_matrix()
        return replace(robot, rotation=rotation)

    def torque(self, robot: Robot, bodies: Array, motion: Sequence[Array]) -> Array:
        """(N, n, k) N·m per m or rad: derivative of the torque of bodies (n, 10) in a motion
        (q, dq, ddq), (N, n) each."""
        here = inverse_dynamics(robot, bodies, *motion)
        there = [
            inverse_dynamics(self.moved(robot, STEP * unit), bodies, *motion)
            for unit in np.eye(self.along.shape[1])
        ]
        return np.stack([(one - here) / STEP for one in there], axis=-1)


def freedoms(robot: Robot) -> Iterator[Freedom]:
    """Of all joints that another one carries: where the first stands, and how, is no matter of the
    arm's own."""
    for j in range(robot.n):
        if robot.parent[j] < 0:
            continue
        yield Freedom(j, "origin", np.eye(3))
        yield Freedom(j, "axis", np.linalg.svd(robot.axis[j][None])[2][1:].T)
