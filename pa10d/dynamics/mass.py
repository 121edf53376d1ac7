"""The joint-space inertia of the rigid bodies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.inverse import inverse_dynamics
from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]


def mass_matrices(robot: Robot, q: Array) -> Array:
    """(N, n, n) kg·m² of the robot's own bodies at poses q (N, n) rad, without rotors.

    Column by column by inverse dynamics without gravity (Walker & Orin, method 1, 1982).
    """
    weightless, still = robot.with_gravity(np.zeros(3)), np.zeros_like(q)
    columns = [
        inverse_dynamics(weightless, robot.parameters, q, still, np.broadcast_to(unit, q.shape))
        for unit in np.eye(robot.n)
    ]
    return np.stack(columns, axis=2)
