"""Does gravity point where the profile's mount says? By what the joints weigh in a first motion.

A URDF's bodies may each be wrong by ``ROUGH``, to either side. Where no such bodies give what was
measured, and with gravity along another axis of the base some do, the mount is wrong rather than
every body. What is left over is compared, of all that was seen.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.control.joint_figures import ROUGH, JointFigures
from pa10d.dynamics import Robot
from pa10d.experiments.felt_bodies import Motion, gravity_felt, rows_felt

Array = NDArray[np.float64]

TIMES = 3.0  # as much is left over by the mount, at least, as by another one
SURE = 6.0  # standard errors, by which it is left over
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def wrong_mount(
    robot: Robot, figures: JointFigures, seen: Sequence[tuple[Array, Array, float]]
) -> str | None:
    """In a sentence; None where the mount may be right. seen: see ``felt_bodies``."""
    strength = float(np.linalg.norm(robot.gravity))
    if strength == 0.0:
        return None
    down = robot.gravity / strength
    ways = {f"{sign}{name}": (1 if sign == "+" else -1) * np.array(axis)
            for name, axis in AXES.items() for sign in "+-"}  # fmt: skip
    others = {name: axis for name, axis in ways.items() if axis @ down < 0.9}
    others["opposite"] = -down
    told = left_by(robot, figures, seen)
    found = {
        name: left_by(robot.with_gravity(strength * axis), figures, seen)
        for name, axis in others.items()
    }
    best = min(found, key=lambda name: found[name])
    if told - found[best] < SURE**2 or told < TIMES**2 * found[best]:
        return None
    opposite = float(others[best] @ down) < -0.9
    where = "the other way" if opposite else f"along {best} of the base"
    return (
        f"by what its joints weigh gravity points {where}, not as the profile's mount says: with "
        f"that the URDF's bodies, each up to {ROUGH:g} times heavier or lighter, leave "
        f"{np.sqrt(told / found[best]):.2g} times as much of what was measured as with gravity "
        f"{where}; correct base.rpy (or gravity) in the profile, and run first_motion again"
    )


def leaning_mount(
    robot: Robot,
    figures: JointFigures,
    seen: Sequence[Motion],
    shaken: Sequence[tuple[int, Array]] = (),
) -> str | None:
    """By how much the base leans against its profile, in a sentence; None where it may stand as it
    says. The arm is moved all the same: bodies are felt beside that."""
    felt = gravity_felt(robot, figures, seen, shaken)
    if felt is None:
        return None
    cosine = felt @ robot.gravity / (np.linalg.norm(felt) * np.linalg.norm(robot.gravity))
    leans = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    x, y, z = felt
    return (
        f"by what its joints weigh the base leans by about {leans:.0f}° against the profile's "
        f"mount: gravity is [{x:.2f}, {y:.2f}, {z:.2f}] m/s² in its frame; correct base.rpy (or "
        "gravity) and run first_motion again: until then weights are known less well"
    )


def left_by(
    robot: Robot, figures: JointFigures, seen: Sequence[tuple[Array, Array, float]]
) -> float:
    """Squared standard errors that the best of all bodies leave in all."""
    tables = [rows_felt(robot, figures, *one) for one in seen]
    rows, wanted, error, _ = (np.concatenate(parts) for parts in zip(*tables, strict=True))
    each = (rows.reshape(len(rows), robot.n, 10) * robot.parameters).sum(axis=2)
    fit = scipy.optimize.lsq_linear(
        each / error[:, None], wanted / error, bounds=(1.0 / ROUGH, ROUGH)
    )
    return float(2.0 * fit.cost)
