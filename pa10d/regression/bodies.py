"""What is known of bodies, as torque shows it: of the base parameters alone."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pa10d.dynamics import BaseParameters, Robot
from pa10d.dynamics.pseudo_inertia import scales
from pa10d.dynamics.rotors import rotors_within
from pa10d.regression.problem import Knowledge

Array = NDArray[np.float64]

WIDE = 10.0  # more than anybody doubts of a link (decision 0255)


def of_base(bodies: Knowledge, robot: Robot, base: BaseParameters) -> Knowledge:
    """Of the base parameters (b,), where ``bodies`` is of the standard ones (10n,): whatever leaves
    them as they are is free, rotors within too."""
    rows = bodies.rows
    size = np.concatenate([scales(link) for link in robot.parameters])
    kept = rows[:, base.kept]
    hidden = (rows[:, base.dropped] - kept @ base.relations) * size[base.dropped]
    out = np.column_stack([hidden, kept @ rotors_within(robot, base).share])
    rest = free_of(out, np.column_stack([kept, bodies.target]))
    rest[:, :-1][np.abs(rest[:, :-1]) * size[base.kept] < 1e-9] = 0.0  # rounding
    return Knowledge(rest[:, :-1], rest[:, -1], bodies.spread)


def widely(standard: Array, robot: Robot, base: BaseParameters) -> Knowledge:
    """Of the base parameters (b,): that bodies are those of ``standard`` (n, 10), each of a link's
    parameters give or take ``WIDE`` times what is usual for its mass and size, there or in the
    robot's file: the larger."""
    pairs = zip(standard, robot.parameters, strict=True)
    sizes = WIDE * np.concatenate([np.maximum(scales(a), scales(b)) for a, b in pairs])
    return of_base(Knowledge.about(standard.reshape(-1), np.diag(1.0 / sizes)), robot, base)


def free_of(directions: Array, rows: Array) -> Array:
    """The rows (r, m) without what ``directions`` (r, k) can take up."""
    if not directions.size:
        return rows
    taken = scipy.linalg.orth(directions, rcond=1e-12)
    return np.asarray(rows - taken @ (taken.T @ rows))
