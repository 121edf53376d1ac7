"""Where links are while their motors keep to a path: behind springs they come late, and swing.

With a motor at q the link x obeys J·ẍ = K·(q - x) + G·x: x is q, filtered by
K/(J·s² + c·s + K - G). What the links' bodies ask for along x is what the motors have to give, the
joints behind and before a link that swings among them. Far below the swing that is what a rigid arm
asks for, above it nothing at all.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.control.gains import gravity_slope
from pa10d.control.joint_figures import JointFigures
from pa10d.dynamics import Robot
from pa10d.dynamics.mass import mass_matrices
from pa10d.trajectory.motions import MotionSamples

Array = NDArray[np.float64]

LOSS = 0.02  # of critical damping, that a spring has at least
FORGETS = 0.1  # … that is counted with ahead of a servo: for how long a swing keeps step with what
# is thought of it nobody knows, and what is out of step is worse than nothing
POSES = 20  # along a motion, in which a link's inertia is looked at


def links_along(
    robot: Robot, figures: JointFigures, bodies: Array, q: Array
) -> tuple[Array, Array]:
    """(n,) each, in the mean over a motion q (N, n) rad: kg·m² of the links, and N·m/rad by which
    gravity pulls them away, 0 where they hang. bodies: (n, 10) standard parameters."""
    along = q[:: max(1, len(q) // POSES)]
    pull = np.maximum(gravity_slope(robot, bodies, along).mean(axis=0), 0.0)
    own = np.diagonal(mass_matrices(robot, along), axis1=1, axis2=2)
    return np.asarray(figures.link * own.mean(axis=0)), pull


def behind_spring(link: float, stiffness: float, pull: float, loss: float) -> tuple[Array, Array]:
    """A link on its spring: how late it is, and what it asks of the motor, as polynomials in s."""
    damps = 2.0 * loss * np.sqrt(stiffness * link)
    return np.array([link, damps, stiffness - pull]), np.array([damps, stiffness])


def links_of(
    robot: Robot, figures: JointFigures, bodies: Array, motion: MotionSamples, loss: float
) -> MotionSamples:
    """Of the links, for a motion (N, n) of the motors that begins at rest; loss: of critical
    damping, of the springs."""
    sprung = np.flatnonzero(np.isfinite(figures.stiffness))
    if not len(sprung):
        return motion
    t, q, dq, ddq = motion
    rate, (link, pull) = 1.0 / float(t[1] - t[0]), links_along(robot, figures, bodies, q)
    out = [values.copy() for values in (q, dq, ddq)]
    for j in sprung:
        late, spring = behind_spring(link[j], float(figures.stiffness[j]), pull[j], loss)
        for values, from_ in zip(out, (q[0, j], 0.0, 0.0), strict=True):
            values[:, j] = from_ + filtered(spring, late, rate, values[:, j] - from_)
    return MotionSamples(t, *out)


def filtered(above: Any, below: Any, rate: float, x: Array) -> Array:
    """above(s)/below(s) of a signal (N,) that is 0 before."""
    return np.asarray(scipy.signal.lfilter(*scipy.signal.bilinear(above, below, rate), x))
