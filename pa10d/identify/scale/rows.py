"""What a regression for one joint's gain is made of: runs with and without known weights.

Joint by joint the measured torque is

    τ_j = Y_j(q, q̇, q̈)·θ_j + offset_j + friction_j,k + s_j·(p_j + μ_j·|load_j|·sign q̇_j)

with p_j the torque that the known body asks for (nothing in runs without it) and s_j the wanted
gain. θ_j is free for every joint, so neither the arm's masses nor a common factor in them matter.
Coulomb and viscous friction are free for every load k: a joint is warmer when it is moved again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot, base_parameters, inverse_dynamics
from pa10d.identify.scale.body import Body
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import RunEquation, prepare

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

BLOCK = 1.0  # s whose residuals are taken as one
CUTOFF = 10.0  # Hz
SEEN = 1e-4  # share of p that must be left beside all else, for a gain to be told
EMPTY = -1


@dataclass(frozen=True)
class WeighedRun:
    """One run. load: number of its weight, EMPTY without one; rigid (M, n, b) | None: the arm's
    own bodies; asked (M, n): N·m that the weight asks for; doubt (M, n, 4): what a standard error
    of its mass or of its centre adds to that; carried (M, n): what the joint carries, roughly: the
    weight and the URDF's bodies."""

    run: RunEquation
    load: int
    rigid: Array | None
    asked: Array
    doubt: Array
    carried: Array

    def with_weight(self, robot: Robot, body: Body, load: int) -> WeighedRun:
        """The same motion with a weight; the torque stays what it was."""
        asked = _torque(self.run, robot, body.parameters(robot))
        doubt = np.stack(
            [
                error * _torque(self.run, robot, slope)
                for error, slope in zip(body.errors, body.slopes(robot), strict=True)
            ],
            axis=2,
        )
        return WeighedRun(
            self.run, load, self.rigid, asked, doubt, self.carried - self.asked + asked
        )


def parts_of(
    robot: Robot, empty: Sequence[Recording], loads: Sequence[tuple[Body, Sequence[Recording]]]
) -> list[WeighedRun]:
    """All runs made ready. Without any empty run the weights are taken for the whole arm: no free
    masses are fitted."""
    arm = base_parameters(robot).kept if empty else None
    found = []
    for load, (body, runs) in enumerate([(None, empty), *loads], EMPTY):
        for recording in runs:
            run = prepare(recording, robot, min(CUTOFF, recording.rate / 8))
            none = np.zeros_like(run.tau)
            rigid = None if arm is None else run.rigid_columns(arm)
            own = none if arm is None else _torque(run, robot, robot.parameters)
            part = WeighedRun(run, EMPTY, rigid, none, np.zeros((*none.shape, 4)), own)
            found.append(part if body is None else part.with_weight(robot, body, load))
    return found


def _torque(run: RunEquation, robot: Robot, parameters: Array) -> Array:
    c = run.context
    return run.lowpass(inverse_dynamics(robot, parameters, c.q, c.dq, c.ddq))


@dataclass(frozen=True)
class WeighingEquations:
    """The rows of one joint: asked (M,), doubt (M, 4) and the loads' numbers, load friction (M,),
    others (M, k), torque (M,); blocks, runs (M,): which stretch of time, which run."""

    asked: Array
    doubt: Array
    load: Ints
    rubbing: Array
    others: Array
    torque: Array
    blocks: Ints
    runs: Ints


def rows_of(
    parts: Sequence[WeighedRun], j: int, torques: Sequence[Array] | None = None
) -> WeighingEquations:
    """Rows of joint j (0-based). torques: (M,) each, in place of what was measured."""
    loads = sorted({part.load for part in parts})
    tables: dict[str, list[Any]] = {name: [] for name in WeighingEquations.__annotations__}
    first = 0
    for number, part in enumerate(parts):
        run, keep = part.run, part.run.keep[:, j]
        c, factor = run.context, run.lowpass.factor
        sign = run.lowpass(np.sign(c.dq))[:, j]
        own = [np.ones_like(sign), c.ddq[::factor, j]]
        for load in loads:
            here = float(part.load == load)
            own += [here * sign, here * c.dq[::factor, j]]
        table = np.stack(own, axis=1)
        if part.rigid is not None:
            table = np.hstack([table, part.rigid[:, j]])
        blocks = first + (run.t / BLOCK).astype(np.int64)
        first = int(blocks.max(initial=first)) + 1
        torque = run.tau[:, j] if torques is None else torques[number]
        count = int(keep.sum())
        tables["asked"].append(part.asked[keep, j])
        tables["doubt"].append(part.doubt[keep, j])
        tables["load"].append(np.full(count, part.load))
        tables["rubbing"].append((np.abs(part.carried[:, j]) * sign)[keep])
        tables["others"].append(table[keep])
        tables["torque"].append(torque[keep])
        tables["blocks"].append(blocks[keep])
        tables["runs"].append(np.full(count, number))
    return WeighingEquations(**{name: np.concatenate(pieces) for name, pieces in tables.items()})


def outside(others: Array) -> Array:
    """(M, k) orthonormal basis of what everything else can explain."""
    size = np.linalg.norm(others, axis=0)
    kept = others[:, size > 0] / size[size > 0]
    if not kept.size:
        return np.zeros((len(others), 0))
    u, s, _ = np.linalg.svd(kept, full_matrices=False)
    return np.asarray(u[:, s > 1e-8 * s[0]])


def without(values: Array, basis: Array) -> Array:
    """What of ``values`` (M,) or (M, k) everything else cannot explain."""
    return np.asarray(values - basis @ (basis.T @ values))


def error_of_weights(x: Array, rows: WeighingEquations) -> float:
    """Standard error of x·p by what is not known of the weights. One balance weighed them all and
    one ruler measured them: what each adds counts in full beside what the others add."""
    moved = np.zeros(rows.doubt.shape[1])
    for load in np.unique(rows.load[rows.load >= 0]):
        here = rows.load == load
        moved += np.abs(x[here] @ rows.doubt[here])
    return float(np.linalg.norm(moved))


def error_over_blocks(score: Array, blocks: Ints) -> float:
    """Standard error of a sum of scores (M,), those of one block taken as one."""
    return float(np.linalg.norm(sums_over_blocks(score, blocks)))


def sums_over_blocks(score: Array, blocks: Ints) -> Array:
    """(B,) whose squares add up to the variance of a sum of scores (M,)."""
    sums = np.bincount(blocks, score)
    count = len(np.unique(blocks))
    return np.asarray(sums * np.sqrt(count / max(count - 1, 1)))
