"""The observation matrix of runs (paper, eq. 9-11), and least squares with it (12)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.regression.equation import RunEquation
from pa10d.regression.layout import Layout, textbook
from pa10d.regression.solution import solve
from pa10d.regression.triangle import Triangle

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
    layout = columns_of(robot)
    parts: list[list[tuple[Array, Array, Array]]] = [[] for _ in range(robot.n)]
    for equation in equations:
        inside = equation.inside
        rigid = equation.rigid_rows(layout.base.kept, layout.seen)
        dq = equation.lowpass(equation.context.dq)
        for j in range(robot.n):
            own = [t.rows(equation.context, j) for t in layout.terms if t.touches(j)]
            rows = np.zeros((len(dq), layout.size))
            rows[:, layout.of_joint[j]] = np.column_stack(
                [rigid[j], equation.lowpass(np.column_stack(own))]
            )
            parts[j].append((rows[inside], equation.tau[inside, j], dq[inside, j]))
    return Stack(
        *([np.concatenate([part[k] for part in joint]) for joint in parts] for k in range(3))
    )


def columns_of(robot: Robot) -> Layout:
    """Those of the textbook, effect by effect, the sign as sharp as sampling allows."""
    layout = textbook(robot)
    kinds = dict.fromkeys(term.effect_id for term in layout.terms)
    ordered = [term for kind in kinds for term in layout.terms if term.effect_id == kind]
    sharp = {
        i: {term.effect.smoothed_over: SIGN_SPEED}
        for i, term in enumerate(ordered)
        if term.effect.smoothed_over
    }
    return replace(layout, terms=tuple(ordered)).with_shapes(sharp)


def least_squares(stack: Stack, weighted: bool) -> tuple[Array, Array]:
    """Estimate (p,) by (12a) or (12b) and each joint's residual RMS (n,); weights come from a
    first, unweighted pass."""
    size = stack.rows[0].shape[1]
    factors = [Triangle(size + 1) for _ in stack.rows]
    for factor, rows, tau in zip(factors, stack.rows, stack.tau, strict=True):
        factor.add(np.column_stack([rows, tau]))
    every = [np.arange(size)] * len(factors)
    h = solve(factors, every, size, np.ones(len(factors))).beta
    sigma = stack.rms(h)
    if weighted:
        h = solve(factors, every, size, sigma).beta
        sigma = stack.rms(h)
    return h, sigma
