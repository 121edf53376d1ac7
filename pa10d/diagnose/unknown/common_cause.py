"""Does one cause that no channel shows act on several joints at once?

A base that tips with time, a load that swings, stamps that lie: nothing of the motion foretells
what they leave. But each acts on all joints at once, through columns that the model gives, so what
the other joints keep at a moment tells how large it is then, and what it leaves in this one. Noise
of one joint's sensor says nothing of another's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    COMMON_LEVEL,
    COMMON_MOMENTS,
    COMMON_RIDGES,
    COMMON_SHARE,
)
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.structure import Prediction, evidence_of, noise_beside
from pa10d.dynamics import inverse_dynamics
from pa10d.effects import Context
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]
Cause = Literal["sway", "stamps"]


@dataclass(frozen=True)
class InCommon:
    """What one cause takes of a joint's (0-based) held-out squared error (share), told by the other
    joints; rms: N·m of it; size: of the cause itself, RMS: rad by which gravity turns; nan of
    stamps."""

    joint: int
    cause: Cause
    share: float
    rms: float
    p_value: float
    size: float


def gravity_turned(context: Context) -> Array:
    """(N, n, 2) N·m/rad: what gravity asks for that turns about the base's x and y."""
    robot, zero = context.robot, np.zeros_like(context.q)
    turned = [np.cross(robot.gravity, axis) for axis in np.eye(3)[:2]]  # per rad, of a small angle
    each = (robot.with_gravity(by) for by in turned)
    return np.stack(
        [inverse_dynamics(one, context.rigid, context.q, zero, zero) for one in each], axis=-1
    )


def momentum(context: Context) -> Array:
    """(N, n, 1) kg·m²/s: what is measured δ(t) too early has q̇·δ of error in its angle, and the
    second derivative of that in its acceleration, of which δ̈ is the most where δ is irregular."""
    still = context.robot.with_gravity(np.zeros(3))
    zero = np.zeros_like(context.q)
    return inverse_dynamics(still, context.rigid, context.q, zero, context.dq)[..., None]


COLUMNS: Mapping[Cause, Callable[[Context], Array]] = {"sway": gravity_turned, "stamps": momentum}


def in_common(state: SearchState, joints: Sequence[int]) -> list[InCommon]:
    """Of these joints those that one cause takes much of, where it is more than one joint; of the
    causes the one that takes most."""
    if len(joints) < 2 or state.train.n < 3:
        return []
    found = [_of_cause(state, joints, cause) for cause in COLUMNS]
    best = max(found, key=lambda of_cause: sum(one.share for one in of_cause))
    return best if len(best) > 1 else []


def _of_cause(state: SearchState, joints: Sequence[int], cause: Cause) -> list[InCommon]:
    """How fast it changes, and how large it may be, is settled on the fit side."""
    sigma = np.asarray(state.fit.sigma)
    fitted = {j: r * sigma[j] for j, r in state.fit.residual.items()}
    known = _columns(state.train, COLUMNS[cause])
    tried = list(product(COMMON_MOMENTS[cause], COMMON_RIDGES))
    gains = [_gain(fitted, _told(state.train, known, fitted, sigma, *at)[0], sigma) for at in tried]
    best = tried[int(np.argmax(gains))]
    residual = state.held_residual()
    asked = _columns(state.held, COLUMNS[cause])
    told, size = _told(state.held, asked, residual, sigma, *best)
    return list(_claims(state, joints, cause, residual, told, size))


def _claims(
    state: SearchState,
    joints: Sequence[int],
    cause: Cause,
    residual: PerJoint,
    told: PerJoint,
    size: float,
) -> Iterator[InCommon]:
    whole = {j: np.ones(len(told[j]), dtype=bool) for j in joints}
    predictions = [Prediction(j, (), told[j], whole[j]) for j in joints]
    noise = noise_beside(state, residual, predictions)
    for p in predictions:
        among = state.train.n * len(COLUMNS)
        claim = evidence_of(state, residual, p, among, noise, COMMON_LEVEL)
        if claim is not None and claim.share > COMMON_SHARE:
            rms = float(np.sqrt(np.mean(p.values**2)))
            angle = size if cause == "sway" else float("nan")
            yield InCommon(p.joint, cause, claim.share, rms, claim.p_value, angle)


def _gain(residual: PerJoint, told: PerJoint, sigma: Array) -> float:
    """Squared error that is taken, in units of what each joint keeps."""
    taken = (np.sum(r**2) - np.sum((r - told[j]) ** 2) for j, r in residual.items())
    return float(sum(t / sigma[j] ** 2 for t, j in zip(taken, residual, strict=True)))


def _columns(side: Side, raw: Callable[[Context], Array]) -> PerJoint:
    """Joint -> (m_j, k) filtered, in the rows that count."""
    per_run = [raw(context) for context in side.contexts]
    pairs = list(zip(side.runs, per_run, strict=True))
    return {
        j: side.gathered([run.filtered(x[:, j], j) for run, x in pairs], j) for j in range(side.n)
    }


def _told(
    side: Side, columns: PerJoint, residual: PerJoint, sigma: Array, seconds: float, ridge: float
) -> tuple[PerJoint, float]:
    """Joint -> (m_j,) N·m by a cause that is constant for so many seconds, each time as large as
    the other joints' errors have it, shrunk by a ridge (of its columns' mean square); and its RMS
    by all joints."""
    moments, count = _moments(side, seconds)
    k = columns[0].shape[1]
    squares, sides = np.zeros((side.n, count, k, k)), np.zeros((side.n, count, k))
    for j, x in columns.items():
        own = x / sigma[j]
        np.add.at(squares[j], moments[j], own[:, :, None] * own[:, None, :])
        np.add.at(sides[j], moments[j], own * (residual[j] / sigma[j])[:, None])
    every = squares.sum(axis=0)
    shrink = ridge * max(float(np.trace(every.mean(axis=0))) / k, 1e-300) * np.eye(k)
    told = {}
    for j, x in columns.items():
        others = sides.sum(axis=0) - sides[j]
        size = np.linalg.solve(every - squares[j] + shrink, others[..., None])[..., 0]
        told[j] = np.sum(x * size[moments[j]], axis=1)
    whole = np.linalg.solve(every + shrink, sides.sum(axis=0)[..., None])[..., 0]
    return told, float(np.sqrt(np.mean(np.sum(whole**2, axis=1))))


def _moments(side: Side, seconds: float) -> tuple[dict[int, NDArray[np.int64]], int]:
    """Joint -> (m_j,) the number of the moment that a row lies in, and how many there are."""
    numbers, count = [], 0
    for run in side.runs:
        own = ((run.t - run.t[0]) / seconds).astype(np.int64)
        numbers.append(own + count)
        count += int(own[-1]) + 1
    return {j: side.gathered(numbers, j).astype(np.int64) for j in range(side.n)}, count
