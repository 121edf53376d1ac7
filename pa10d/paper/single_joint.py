"""One joint moving alone: equation 6, both sides filtered alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass
from pa10d.regression.equation import prepare

Array = NDArray[np.float64]
Gravity = Literal["none", "fitted", "subtracted"]
GRAVITY: dict[str, str] = {
    "none": "gravity does not act on the joint in this pose",
    "fitted": "gravity was fitted along as A·sin q + B·cos q, all other joints standing",
    "subtracted": "the gravity of the given model was subtracted",
}
SMEAR = 0.5  # periods of the cut-off over which a reversal is smeared
OTHERS = 0.05  # of the joint's own fast speed, by which others may be shaken


@dataclass(frozen=True)
class JointEquation:
    """I·q̈ + Fc·sign(q̇) + Fv·q̇ (+ constant, gravity) = τ.

    columns (M, 4 + g) q̈, sign q̇, q̇, 1 and, where fitted, sin q, cos q; tau (M,) N·m; speed (M,)
    rad/s, signed; block (M,) which swing a sample belongs to; all filtered alike
    runs (B,) which recording a swing belongs to; independent: share of the samples that the
    filter leaves independent of each other
    blur (M,) rad/s, by which the filter mixes neighbouring speeds near that run's reversals
    """

    joint: int
    columns: Array
    tau: Array
    speed: Array
    block: NDArray[np.int64]
    gravity: Gravity
    blur: Array
    runs: NDArray[np.int64]
    independent: float

    def draws(self, replicates: int, seed: int) -> NDArray[np.int64]:
        """(R, B): how often each swing counts in each bootstrap replicate, drawn within its run."""
        rng = np.random.default_rng(seed)
        out = np.zeros((replicates, len(self.runs)), dtype=np.int64)
        for run in np.unique(self.runs):
            swings = np.flatnonzero(self.runs == run)
            share = np.full(len(swings), 1 / len(swings))
            out[:, swings] = rng.multinomial(len(swings), share, size=replicates)
        return out


def single_joint(
    recordings: Sequence[Recording],
    robot: Robot,
    joint: int,
    cutoff: float = 25.0,
    gravity: Gravity = "none",
    parameters: Array | None = None,
) -> JointEquation:
    """From recordings in which only ``joint`` (0-based) moved, to and fro.

    gravity: "none" where the pose takes care of it; "fitted": along with the rest; "subtracted":
    by the standard ``parameters`` (n, 10), default the robot's own. A constant torque (sensor
    bias) is always fitted along: it is not friction. What the others' yielding asks of the joint is
    taken away by the robot's own parameters.
    """
    parts = [
        _prepared(recording, robot, joint, cutoff, gravity, parameters) for recording in recordings
    ]
    blocks: list[NDArray[np.int64]] = []
    runs: list[int] = []
    for number, part in enumerate(parts):
        blocks.append(part.block + len(runs))
        runs += [number] * len(part.runs)
    return JointEquation(
        joint,
        np.vstack([p.columns for p in parts]),
        np.concatenate([p.tau for p in parts]),
        np.concatenate([p.speed for p in parts]),
        np.concatenate(blocks),
        gravity,
        np.concatenate([p.blur for p in parts]),
        np.array(runs, dtype=np.int64),
        min(p.independent for p in parts),
    )


def _prepared(
    recording: Recording,
    robot: Robot,
    joint: int,
    cutoff: float,
    gravity: Gravity,
    parameters: Array | None,
) -> JointEquation:
    equation = prepare(recording, robot, cutoff)
    c = equation.context
    # at the raw rate: a threshold must not jump from one sample of a slow reversal to the next
    lowpass = Lowpass(len(c.t), equation.lowpass.rate, cutoff)
    inside = slice(lowpass.settle, len(c.t) - lowpass.settle)
    fast = np.quantile(np.abs(c.dq), 0.95, axis=0)
    if fast[joint] < 1e-3:
        raise UserError(f"{recording.name}: joint {joint + 1} does not move")
    other = int(np.argmax(np.where(np.arange(robot.n) == joint, -1.0, fast)))
    if robot.n > 1 and fast[other] > OTHERS * fast[joint]:
        raise UserError(
            f"{recording.name}: joint {other + 1} moves as well ({fast[other]:.3g} rad/s beside "
            f"{fast[joint]:.3g}); expected joint {joint + 1} alone"
        )
    q, dq, ddq = (x[:, joint] for x in (c.q, c.dq, c.ddq))
    raw = [ddq, np.sign(dq), dq, np.ones_like(q)]
    tau = lowpass(equation.raw_tau[:, joint] - _of_others(robot, joint, c.q, c.dq, c.ddq))
    if gravity == "fitted":
        raw += [np.sin(q), np.cos(q)]
    elif gravity == "subtracted":
        known = robot.parameters if parameters is None else parameters
        zero = np.zeros_like(c.q)
        tau = tau - lowpass(inverse_dynamics(robot, known, c.q, zero, zero)[:, joint])
    columns = lowpass(np.column_stack(raw))
    speed = columns[:, 2]
    blur = float(np.quantile(np.abs(columns[inside, 0]), 0.9)) * SMEAR / cutoff
    block = _swings(speed[inside], 0.2 * fast[joint])
    return JointEquation(
        joint,
        columns[inside],
        tau[inside],
        speed[inside],
        block,
        gravity,
        np.full(len(block), blur),
        np.zeros(int(block.max()) + 1, dtype=np.int64),
        min(1.0, 2.0 * cutoff / lowpass.rate),
    )


def _of_others(robot: Robot, joint: int, q: Array, dq: Array, ddq: Array) -> Array:
    """(N,) N·m that the others' small motion asks of the joint, by the robot's own parameters: a
    servo yields a little when a neighbour turns round, just where friction is looked at."""
    alone = np.zeros(robot.n)
    alone[joint] = 1.0
    whole = inverse_dynamics(robot, robot.parameters, q, dq, ddq)[:, joint]
    return whole - inverse_dynamics(robot, robot.parameters, q, dq * alone, ddq * alone)[:, joint]


def _swings(speed: Array, enough: float) -> NDArray[np.int64]:
    """(M,) number of the swing: a new one begins where the speed turns positive again, having
    been clearly negative (a whole period, both directions in each)."""
    number = np.zeros(len(speed), dtype=np.int64)
    crossings = np.flatnonzero((speed[1:] > 0) & (speed[:-1] <= 0)) + 1
    last, count = 0, 0
    for at in crossings:
        if speed[last:at].min() < -enough and speed[last:at].max() > enough:
            count += 1
            number[at:] = count
            last = int(at)
    return number
