"""Rotor inertias that torque shows only in a sum with the bodies.

Where a joint's axis never turns, its rotor does what inertia about that axis does. The rotor of a
shoulder behind a vertical axis is less plain: it does what a round inertia of the same size does,
less as much about the axis before it. Least squares leaves such a rotor to the base parameters; no
body need be able to have it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pa10d.dynamics.base import BaseParameters, random_motion
from pa10d.dynamics.regressor import regressor
from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]

SPANNED = 1e-5  # share of a rotor inertia's column outside the rigid base, below which it is in it
SEEN = 1e-12  # of the largest column of a joint's equation


@dataclass(frozen=True)
class Rotors:
    """seen (n, b): which base parameters load which joint; joints: whose rotor inertia the base
    takes in; share (b, r): what 1 kg·m² (or kg) of each of these adds to the base parameters."""

    seen: NDArray[np.bool_]
    joints: tuple[int, ...]
    share: Array


def rotors_within(robot: Robot, base: BaseParameters) -> Rotors:
    """Asked of a random motion."""
    q, dq, ddq = random_motion(robot, 200, seed=2)
    columns = regressor(robot, q, dq, ddq, base.kept)
    size = np.abs(columns).max(axis=0)
    torques = np.zeros((*ddq.shape, robot.n))
    every = np.arange(robot.n)
    torques[:, every, every] = ddq
    matrix, wanted = (m.reshape(-1, m.shape[2]) for m in (columns, torques))
    found = scipy.linalg.lstsq(matrix, wanted)[0]
    left = np.linalg.norm(wanted - matrix @ found, axis=0)
    within = np.flatnonzero(left < SPANNED * np.linalg.norm(wanted, axis=0))
    return Rotors(size > SEEN * size.max(axis=0), tuple(within.tolist()), found[:, within])
