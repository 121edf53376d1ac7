"""An arm that weighs other than its URDF says, as plans and pre-checks see it: it carries a weight
at its last joint, or its bodies were felt. Their shapes stay those of the URDF."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.robot import Robot, rigid_body

Array = NDArray[np.float64]

IRON = 7850.0  # kg/m³: what weights are made of


@dataclass(frozen=True)
class CarryingRobot(Robot):
    """bare: the arm as its URDF has it; centre (3,) m of a weight in the last joint's frame, None:
    it carries none; radius: m of a ball of iron of that mass, as nobody said what shape it has."""

    bare: Robot | None = None
    centre: Array | None = None
    radius: float = 0.0


def carrying(robot: Robot, mass: float, com: Array) -> CarryingRobot:
    """The arm with a weight (kg) whose centre (3,) m is given in the last joint's frame."""
    parameters = robot.parameters.copy()
    parameters[-1] += rigid_body(mass, com)
    radius = float(np.cbrt(3.0 * mass / (4.0 * np.pi * IRON)))
    return replace(weighing(robot, parameters), centre=np.asarray(com, float), radius=radius)


def weighing(robot: Robot, bodies: Array) -> CarryingRobot:
    """The arm with these bodies (n, 10), as they were felt: how thick they are nobody felt."""
    fields = {name: getattr(robot, name) for name in Robot.__dataclass_fields__}
    bare = robot.bare if isinstance(robot, CarryingRobot) else robot
    fields["parameters"] = bodies
    return CarryingRobot(**fields, bare=bare)
