"""Whether gravity comes from where the profile says: a base that is tilted, and nobody said so.

Whatever the bodies weigh, their weight turns with the pose as gravity's direction has it. So the
direction is left free beside the textbook model, and must explain what the given one leaves.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding
from pa10d.checks.textbook_fit import blocks_of, fit_textbook, steady_sign, textbook_columns
from pa10d.checks.textbook_view import CUTOFF, middle_of, surely_less
from pa10d.dynamics import Robot, base_parameters
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import RunEquation, prepare

Array = NDArray[np.float64]

TRIAL = 0.3  # rad: any direction that is none of the robot's own
STEPS = 12
FEWEST_JOINTS = 2  # that agree on it: one alone may lack something of its own


def check_gravity(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """A direction of gravity that explains a recording surely better than the profile's."""
    size = float(np.linalg.norm(robot.gravity))
    if size == 0.0:
        return
    part = middle_of(recording)
    axes = _axes(robot.gravity / size)
    kept = base_parameters(robot.with_gravity(size * _direction(axes, np.full(2, TRIAL)))).kept
    run = prepare(replace(part, dq=None), robot, min(CUTOFF, part.rate / 8))
    whole = textbook_columns(run, kept)
    keep = run.keep & steady_sign(run)
    if keep.sum() < 3 * whole.shape[2]:
        return
    still, *pulls = (
        _rigid(run, robot.with_gravity(g), kept) for g in (np.zeros(3), *(size * axes))
    )
    weights = 1.0 / np.maximum(run.tau.std(axis=0), 1e-9)
    given = np.zeros(2)

    def left(tilt: Array, weights: Array) -> Array:
        columns = whole.copy()
        direction = _direction(np.eye(3), tilt)
        columns[:, :, : len(kept)] = still + sum(
            share * (pull - still) for share, pull in zip(direction, pulls, strict=True)
        )
        parameters, _ = fit_textbook(columns, run.tau, keep, weights)
        return np.where(keep, (run.tau - columns @ parameters) * weights, 0.0)

    weights = weights / np.maximum(np.sqrt(np.mean(left(given, weights) ** 2, axis=0)), 1e-9)
    found = scipy.optimize.least_squares(
        lambda tilt: left(tilt, weights)[keep], given, max_nfev=STEPS
    )
    blocks = blocks_of(run)
    old, new = (
        [np.bincount(blocks, r**2).astype(np.float64) for r in left(tilt, weights).T]
        for tilt in (given, found.x)
    )
    better = [j for j in range(robot.n) if surely_less(new[j], old[j])]
    if len(better) < FEWEST_JOINTS:
        return
    share = float(np.sum([new[j] for j in better]) / np.sum([old[j] for j in better]))
    named = ", ".join(str(j + 1) for j in better)
    angle = np.degrees(np.linalg.norm(found.x))
    yield CheckFinding(
        "warning",
        "gravity",
        f"gravity seems to come from {angle:.0f}° beside where the profile has it: with its "
        f"direction left free, the textbook model leaves joints {named} {share:.0%} of their error",
        "level the base, or enter its orientation in the profile; or is an encoder's zero off? "
        "A tilt changes its sign with the first joint turned by 180°, a zero does not",
    )


def _axes(down: Array) -> Array:
    """(3, 3) rows: the direction of gravity, and two level ones."""
    other = np.eye(3)[int(np.argmin(np.abs(down)))]
    first = np.cross(down, other)
    first /= np.linalg.norm(first)
    return np.stack([down, first, np.cross(down, first)])


def _direction(axes: Array, tilt: Array) -> Array:
    """(3,) unit vector ``tilt`` (2,) rad away from the first of the axes, towards the others."""
    angle = float(np.linalg.norm(tilt))
    towards = tilt * np.sinc(angle / np.pi)
    return np.asarray(np.append(np.cos(angle), towards) @ axes)


def _rigid(run: RunEquation, robot: Robot, kept: NDArray[np.int64]) -> Array:
    """(M, n, b) columns of the same motion under another gravity."""
    return replace(run, context=replace(run.context, robot=robot)).rigid_columns(kept)
