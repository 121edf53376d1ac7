"""Estimates side by side: fast samples or all, free or feasible, the paper's way or ours."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics import BaseParameters, Robot, base_parameters
from pa10d.dynamics.feasible import definiteness, feasible_fit
from pa10d.paper.penalty import penalty_fit
from pa10d.paper.stack import Stack, least_squares, stacked
from pa10d.regression.equation import RunEquation

Array = NDArray[np.float64]


def estimation_variants(
    train: Sequence[RunEquation],
    verify: Sequence[RunEquation],
    robot: Robot,
    boundary: Array,
    alpha: tuple[float, float] = (1.0, 1.0),
) -> dict[str, Any]:
    """What each way costs and gains, all judged on the same other trajectory, all its samples.

    boundary (n,) rad/s. Sets: A, rows in which the joint is faster than its boundary velocity; B,
    all rows. ``rms``: of all samples of the other trajectory; ``rms_above_boundary``: of its fast
    ones, where either set's model claims to hold. Ways: ``ols`` (12a), ``wls`` (12b), ``penalty``
    (17) from ols with the paper's m, I > 0, ``penalty_physical`` the same with bodies that can
    exist, ``feasible`` ours.
    """
    base = base_parameters(robot)
    everything, other = stacked(train, robot), stacked(verify, robot)
    sets = {"A": everything.chosen(boundary), "B": everything}
    out: dict[str, Any] = {
        "boundary_velocity": np.asarray(boundary).tolist(),
        "share_of_samples": [
            len(a) / len(b) for a, b in zip(sets["A"].tau, sets["B"].tau, strict=True)
        ],
    }
    for name, stack in sets.items():
        for j, rows in enumerate(stack.rows):
            if len(rows) < rows.shape[1]:
                raise UserError(
                    f"set {name}: joint {j + 1} has {len(rows)} samples faster than "
                    f"{boundary[j]:.3g} rad/s, expected at least {rows.shape[1]}: a faster "
                    "trajectory, or a lower boundary velocity"
                )
        out[name] = _ways(stack, other, other.chosen(boundary), robot, base, alpha)
    return out


def _ways(
    stack: Stack,
    other: Stack,
    fast: Stack,
    robot: Robot,
    base: BaseParameters,
    alpha: tuple[float, float],
) -> dict[str, Any]:
    plain, _ = least_squares(stack, weighted=False)
    weighted, weights = least_squares(stack, weighted=True)
    rows, tau = stack.whole()
    prior, b = robot.parameters, len(base)

    def free(h: Array) -> tuple[Array, None]:
        return h, None

    def paper(rule: Any) -> tuple[Array, Array]:
        found = penalty_fit(rows, tau, plain, base, prior, alpha, rule)
        return found.base, found.standard

    def ours() -> tuple[Array, Array]:
        r = np.asarray(np.linalg.qr(np.column_stack(stack.whole(weights)), mode="r"))
        size = r.shape[1] - 1 - b
        low, high = np.zeros(size), np.full(size, np.inf)
        found = feasible_fit(r[:, :-1], r[:, -1], base, prior, low, high)
        return np.concatenate([base.of(found.standard), found.extra]), found.standard

    recipes: dict[str, Callable[[], tuple[Array, Array | None]]] = {
        "ols": lambda: free(plain),
        "wls": lambda: free(weighted),
        "penalty": lambda: paper("paper"),
        "penalty_physical": lambda: paper("physical"),
        "feasible": ours,
    }
    out: dict[str, Any] = {
        "condition_number": float(np.linalg.cond(rows)),
        "samples": [len(t) for t in stack.tau],
    }
    for name, recipe in recipes.items():
        began = time.perf_counter()
        h, standard = recipe()
        took = time.perf_counter() - began
        smallest = None if standard is None else definiteness(standard)
        out[name] = {
            "parameters": h.tolist(),
            "rms_train": stack.rms(h).tolist(),
            "rms": other.rms(h).tolist(),
            "rms_above_boundary": fast.rms(h).tolist(),
            "feasible": None if smallest is None else bool(np.all(smallest > 0)),
            "smallest_pseudo_inertia": None if smallest is None else smallest.tolist(),
            "from_estimate": float(np.linalg.norm(h - plain)),
            "seconds": took,
        }
    return out
