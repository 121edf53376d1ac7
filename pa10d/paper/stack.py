"""The observation matrix of runs (paper, eq. 9-11), and least squares with it (12)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.dynamics.observation import model_columns
from pa10d.effects.base import smooth_sign
from pa10d.regression.equation import RunEquation

Array = NDArray[np.float64]

SIGN_SPEED = 1e-3  # rad/s over which the sign is smoothed: as sharp as sampling allows


@dataclass(frozen=True)
class Stack:
    """Equation 11 of several runs by joints: rows[j] (M_j, p), tau[j] (M_j,), speed[j] (M_j,).

    Columns: base inertial parameters, rotor inertias that are not among them, Fc and Fv per joint.
    """

    rows: list[Array]
    tau: list[Array]
    speed: list[Array]

    def chosen(self, faster_than: Array | None) -> Stack:
        """The rows in which the joint itself is faster than its threshold (rad/s)."""
        if faster_than is None:
            return self
        masks = [np.abs(v) > limit for v, limit in zip(self.speed, faster_than, strict=True)]
        return Stack(
            *(
                [part[mask] for part, mask in zip(parts, masks, strict=True)]
                for parts in (self.rows, self.tau, self.speed)
            )
        )

    def whole(self, weight: Array | None = None) -> tuple[Array, Array]:
        """W_o (rows, p) and τ_o (rows,); each joint's rows divided by ``weight`` where given."""
        w = np.ones(len(self.rows)) if weight is None else weight
        rows = np.vstack([r / s for r, s in zip(self.rows, w, strict=True)])
        return rows, np.concatenate([t / s for t, s in zip(self.tau, w, strict=True)])

    def rms(self, h: Array) -> Array:
        """(n,) N·m of what an estimate leaves, per joint."""
        return np.array(
            [
                np.sqrt(np.mean((t - r @ h) ** 2)) if len(t) else np.nan
                for r, t in zip(self.rows, self.tau, strict=True)
            ]
        )


def stacked(equations: Sequence[RunEquation], robot: Robot) -> Stack:
    """Observation matrix and torque of runs that are filtered alike; standstill counts too, only
    the ends of runs do not."""
    columns = model_columns(robot)
    parts: list[list[tuple[Array, Array, Array]]] = [[] for _ in range(robot.n)]
    for equation in equations:
        c, inside = equation.context, equation.inside
        rigid = equation.rigid_columns(columns.inertial)
        raw = np.stack(
            [c.ddq, np.column_stack([smooth_sign(v, SIGN_SPEED) for v in c.dq.T]), c.dq], axis=1
        )
        ddq, sign, dq = np.moveaxis(equation.lowpass(raw), 1, 0)
        b, r = len(columns.inertial), len(columns.rotor)
        for j in range(robot.n):
            rows = np.zeros((len(dq), len(columns)))
            rows[:, :b] = rigid[:, j]
            rows[:, b : b + r] = np.where(columns.rotor == j, ddq[:, [j]], 0.0)
            rows[:, b + r + j], rows[:, b + r + robot.n + j] = sign[:, j], dq[:, j]
            parts[j].append((rows[inside], equation.tau[inside, j], dq[inside, j]))
    return Stack(
        *([np.concatenate([part[k] for part in joint]) for joint in parts] for k in range(3))
    )


def least_squares(stack: Stack, weighted: bool) -> tuple[Array, Array]:
    """Estimate (p,) by (12a) or (12b) and each joint's residual RMS (n,); weights come from a
    first, unweighted pass."""
    h = _solve(*stack.whole())
    sigma = stack.rms(h)
    if weighted:
        h = _solve(*stack.whole(sigma))
        sigma = stack.rms(h)
    return h, sigma


def _solve(rows: Array, tau: Array) -> Array:
    scale = np.linalg.norm(rows, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    return np.asarray(np.linalg.lstsq(rows / scale, tau, rcond=1e-12)[0] / scale, dtype=float)
