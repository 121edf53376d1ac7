"""Where to begin a search whose random motions all end in the floor, in a wall or too heavy.

Penalties lead out of a slight touch; a motion that is deep in the floor for half of its way stays
there, for each way out is barred by another part of it. Begun small, in a pose with room around it,
it grows until it meets what is in the way.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.trajectory.excitation.problem import ExcitationProblem

Array = NDArray[np.float64]

POSES = 500  # among which an open one is looked for
NARROWER = 0.9  # of a motion that cannot be run, again and again
LEAST = 0.03  # of its size: a smaller one tells nothing


def open_pose(problem: ExcitationProblem, rng: np.random.Generator) -> Array:
    """Of random poses (m,) that the moving joints can hold, the farthest from all bodies."""
    room = problem.room
    home = np.array(problem.pose)[list(problem.joints)]
    poses = np.vstack([home, rng.uniform(room.lower, room.upper, (POSES, len(home)))])
    rest = np.zeros_like(poses)
    light = np.all(np.abs(problem.arm_torque(poses, rest, rest)) <= room.torque, axis=1)
    gaps = problem.capsules.clearance(problem.whole(poses))
    free = gaps.min(axis=1) if gaps.size else np.zeros(len(poses))
    return poses[np.argmax(np.where(light, free, -np.inf))]


def narrower(problem: ExcitationProblem, x: Array, about: Array) -> Array:
    """As much of a motion about a pose (m,) as can be run; all of it where hardly any can."""
    share = 1.0
    while share > LEAST:
        narrow = share * x
        narrow[0] = about + share * (x[0] - about)
        if problem.excess(narrow) <= 0.0:
            return narrow
        share *= NARROWER
    return x
