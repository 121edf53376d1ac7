"""A known weight sets the scale of every torque: gains of the joints, absolute, with their errors.

What a sensor or a motor current calls one newton metre may be anything near it, and no fit to the
arm alone can tell: all masses would come out with the same error. A body that is known breaks that.
Joint by joint the measured torque is

    τ_j = Y_j(q, q̇, q̈)·θ_j + friction_j + s_j·(p_j + μ_j·|p_j|·sign q̇_j)

with p_j the torque that the known body asks for (nothing in runs without it) and s_j the wanted
gain. θ_j is free for every joint, so neither the arm's masses nor a common factor in them matter.
Friction that grows with the load, equal in both directions, goes into μ_j; friction of gears that
differ by the direction of power flow does not, and leaves half of itself in s_j.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot, base_parameters, inverse_dynamics
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import RunEquation, prepare

Array = NDArray[np.float64]

BLOCK = 1.0  # s whose residuals are taken as one
CUTOFF = 10.0  # Hz
SEEN = 1e-4  # share of p that must be left beside all else, for a gain to be told
WANTED = 0.01  # standard error of a gain that is worth another, heavier body
SPARE = 0.8  # of a joint's torque limit that a heavier body may ask for in the same motion
LARGEST = 5.0  # times the mass that was hung: beyond, ask again after trying


@dataclass(frozen=True)
class Load:
    """Runs with one known body: parameters (n, 10) as PARAMETER_NAMES, zero in links without it."""

    runs: Sequence[Recording]
    parameters: Array
    mass: float


@dataclass(frozen=True)
class Gains:
    """gain, std_error (n,): measured torque over true torque; NaN where the body asks nothing of
    the joint. next_mass: kg to hang for a standard error of WANTED, None where it is reached or no
    mass within the limits would do."""

    gain: Array
    std_error: Array
    next_mass: float | None


def torque_gains(robot: Robot, empty: Sequence[Recording], loads: Sequence[Load]) -> Gains:
    """Gains from runs without and with known bodies.

    Without any empty run the known bodies are taken for the whole arm: no free masses are fitted.
    """
    arm = base_parameters(robot).kept if empty else np.empty(0, dtype=np.int64)
    nothing = np.zeros((robot.n, 10))
    parts = [
        (_prepared(run, robot), known)
        for runs, known in [(empty, nothing), *((load.runs, load.parameters) for load in loads)]
        for run in runs
    ]
    gain, error = np.full((2, robot.n), np.nan)
    rigid = [run.rigid_columns(arm) if len(arm) else None for run, _ in parts]
    asked = [_asked(run, robot, known) for run, known in parts]
    for j in range(robot.n):
        columns, torque, blocks, first = [], [], [], 0
        for (run, _), own, p in zip(parts, rigid, asked, strict=True):
            keep = run.keep[:, j]
            columns.append(_columns(run, own, p, j)[keep])
            torque.append(run.tau[keep, j])
            blocks.append(first + (run.t[keep] / BLOCK).astype(np.int64))
            first = int(blocks[-1].max(initial=first)) + 1
        found = _slope(np.concatenate(columns), np.concatenate(torque), np.concatenate(blocks))
        if found is not None:
            gain[j], error[j] = found
    return Gains(gain, error, _next_mass(robot, error, loads, parts, asked))


def _prepared(run: Recording, robot: Robot) -> RunEquation:
    return prepare(run, robot, min(CUTOFF, run.rate / 8))


def _asked(run: RunEquation, robot: Robot, known: Array) -> Array:
    """(M, n) N·m that the known body asks of each joint."""
    c = run.context
    return run.lowpass(inverse_dynamics(robot, known, c.q, c.dq, c.ddq))


def _columns(run: RunEquation, rigid: Array | None, asked: Array, j: int) -> Array:
    """(M, k): p first, then load friction, rotor, friction, offset, then the arm's bodies."""
    c, factor = run.context, run.lowpass.factor
    sign = run.lowpass(np.sign(c.dq))[:, j]
    p = asked[:, j]
    own = [p, np.abs(p) * sign, c.ddq[::factor, j], sign, c.dq[::factor, j], np.ones_like(p)]
    table = np.stack(own, axis=1)
    return table if rigid is None else np.hstack([table, rigid[:, j]])


def _slope(columns: Array, torque: Array, blocks: NDArray[np.int64]) -> tuple[float, float] | None:
    """Coefficient of the first column and its standard error over blocks; None: cannot be told."""
    p, others = columns[:, 0], columns[:, 1:]
    size = np.linalg.norm(others, axis=0)
    others = others[:, size > 0] / size[size > 0]
    u, s, _ = np.linalg.svd(others, full_matrices=False)
    basis = u[:, s > 1e-8 * s[0]]
    x = p - basis @ (basis.T @ p)
    power = float(x @ x)
    if power <= SEEN * float(p @ p) or power == 0:
        return None
    slope = float(x @ torque) / power
    residual = torque - basis @ (basis.T @ torque) - slope * x
    scores = np.bincount(blocks, x * residual)
    count = len(np.unique(blocks))
    error = np.sqrt((scores**2).sum() * count / max(count - 1, 1)) / power
    return slope, float(error)


def _next_mass(
    robot: Robot,
    error: Array,
    loads: Sequence[Load],
    parts: Sequence[tuple[RunEquation, Array]],
    asked: Sequence[Array],
) -> float | None:
    """The error falls as the mass grows, until a joint's torque runs out."""
    told = np.isfinite(error)
    heaviest = max((load.mass for load in loads), default=0.0)
    if heaviest <= 0 or not told.any() or error[told].max() <= WANTED:
        return None
    wanted = heaviest * min(float(error[told].max()) / WANTED, LARGEST)
    for (run, _), p in zip(parts, asked, strict=True):
        drawn, own = np.abs(run.tau).max(axis=0), np.abs(p).max(axis=0)
        room = np.where(own > 0, (SPARE * robot.effort - drawn) / np.maximum(own, 1e-12), np.inf)
        wanted = min(wanted, heaviest * (1.0 + max(float(room.min()), 0.0)))
    return float(f"{wanted:.2g}") if wanted > 1.05 * heaviest else None
