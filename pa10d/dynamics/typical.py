"""What inertia a joint moves in its usual poses."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.dynamics.regressor import inverse_dynamics
from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]

POSES = 64


def typical_inertia(robot: Robot, parameters: Array) -> Array:
    """(n,) kg·m²: median of M_jj over poses spread evenly over the joints' ranges.

    parameters: (n, 10) of the rigid bodies. Positive, even where a badly excited fit makes M_jj
    negative.
    """
    n = robot.n
    low = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    q = low + (high - low) * scipy.stats.qmc.Halton(n, scramble=False).random(POSES)
    rest = np.zeros_like(q)
    still = inverse_dynamics(robot, parameters, q, rest, rest)
    found = [
        (inverse_dynamics(robot, parameters, q, rest, rest + e) - still)[:, j]
        for j, e in enumerate(np.eye(n))
    ]
    return np.maximum(np.abs(np.median(found, axis=1)), 1e-6)
