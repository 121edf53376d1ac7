"""What inertia a joint moves in its usual poses."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.dynamics.inverse import inverse_dynamics
from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]

POSES = 64


def typical_inertia(robot: Robot, parameters: Array) -> Array:
    """(n,) kg·m²: median of M_jj over poses spread evenly over the joints' ranges.

    parameters: (n, 10) of the rigid bodies. Positive, even where a badly excited fit makes M_jj
    negative.
    """
    q = usual_poses(robot)
    rest = np.zeros_like(q)
    still = inverse_dynamics(robot, parameters, q, rest, rest)
    found = [
        (inverse_dynamics(robot, parameters, q, rest, rest + e) - still)[:, j]
        for j, e in enumerate(np.eye(robot.n))
    ]
    return np.maximum(np.abs(np.median(found, axis=1)), 1e-6)


def usual_poses(robot: Robot) -> Array:
    """(P, n) spread evenly over the joints' ranges, the same ones every time."""
    low = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    return np.asarray(
        low + (high - low) * scipy.stats.qmc.Halton(robot.n, scramble=False).random(POSES)
    )
