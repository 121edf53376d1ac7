"""Estimates side by side: fast samples or all, free or feasible, the paper's way or ours."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics import BaseParameters, Robot, base_parameters
from pa10d.dynamics.feasible import definiteness, feasible_fit
from pa10d.dynamics.rotors import rotors_within
from pa10d.paper.penalty import Rule, penalty_fit
from pa10d.paper.stack import Stack, least_squares, stacked
from pa10d.regression.equation import RunEquation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JudgedEstimate:
    """One way's parameters h, and what they cost and gain.

    rms_train, rms, rms_above_boundary: (n,) N·m on the way's own rows, on all samples of the other
    trajectory, and on its fast ones, where either set's model claims to hold
    feasible: whether its bodies can exist, None where the way asks for none
    smallest_pseudo_inertia: (n,) smallest eigenvalue per link; from_estimate: distance from ols
    """

    parameters: Array
    rms_train: Array
    rms: Array
    rms_above_boundary: Array
    feasible: bool | None
    smallest_pseudo_inertia: Array | None
    from_estimate: float
    seconds: float


@dataclass(frozen=True)
class SetEstimates:
    """One set of rows. samples: per joint; ways: by name."""

    condition_number: float
    samples: list[int]
    ways: dict[str, JudgedEstimate]


@dataclass(frozen=True)
class Variants:
    """share_of_samples: per joint, of set A in set B; sets: "A" and "B"."""

    share_of_samples: list[float]
    sets: dict[str, SetEstimates]

    def ours(self, name: Literal["A", "B"]) -> JudgedEstimate:
        """Of a set, with bodies that can exist."""
        return self.sets[name].ways["feasible"]


def estimation_variants(
    train: Sequence[RunEquation],
    verify: Sequence[RunEquation],
    robot: Robot,
    boundary: Array,
    alpha: tuple[float, float] = (1.0, 1.0),
) -> Variants:
    """What each way costs and gains, all judged on the same other trajectory.

    boundary (n,) rad/s. Sets: A, rows in which the joint is faster than its boundary velocity; B,
    all rows. Ways: ``ols`` (12a), ``wls`` (12b), ``penalty`` (17) from ols with the paper's
    m, I > 0, ``penalty_physical`` the same with bodies that can exist, ``feasible`` ours.
    """
    base = base_parameters(robot)
    everything, other = stacked(train, robot), stacked(verify, robot)
    sets = {"A": everything.chosen(boundary), "B": everything}
    share = [len(a) / len(b) for a, b in zip(sets["A"].tau, sets["B"].tau, strict=True)]
    found = {}
    for name, stack in sets.items():
        for j, rows in enumerate(stack.rows):
            if len(rows) < rows.shape[1]:
                raise UserError(
                    f"set {name}: joint {j + 1} has {len(rows)} samples faster than "
                    f"{boundary[j]:.3g} rad/s, expected at least {rows.shape[1]}: a faster "
                    "trajectory, or a lower boundary velocity"
                )
        found[name] = _ways(stack, other, other.chosen(boundary), robot, base, alpha)
    return Variants(share, found)


def _ways(
    stack: Stack,
    other: Stack,
    fast: Stack,
    robot: Robot,
    base: BaseParameters,
    alpha: tuple[float, float],
) -> SetEstimates:
    plain, _ = least_squares(stack, weighted=False)
    weighted, weights = least_squares(stack, weighted=True)
    rows, tau = stack.whole()
    prior, b = robot.parameters, len(base)

    def free(h: Array) -> tuple[Array, None]:
        return h, None

    def paper(rule: Rule) -> tuple[Array, Array]:
        found = penalty_fit(rows, tau, plain, base, prior, alpha, rule)
        return found.base, found.standard

    def ours() -> tuple[Array, Array]:
        r = np.asarray(np.linalg.qr(np.column_stack(stack.whole(weights)), mode="r"))
        size = r.shape[1] - 1 - b
        low, high = np.zeros(size), np.full(size, np.inf)
        share = rotors_within(robot, base).share
        found = feasible_fit(r[:, :-1], r[:, -1], base, prior, low, high, rotors=share)
        whole = base.of(found.standard) + share @ found.rotors
        return np.concatenate([whole, found.extra]), found.standard

    recipes: dict[str, Callable[[], tuple[Array, Array | None]]] = {
        "ols": lambda: free(plain),
        "wls": lambda: free(weighted),
        "penalty": lambda: paper("paper"),
        "penalty_physical": lambda: paper("physical"),
        "feasible": ours,
    }
    ways = {}
    for name, recipe in recipes.items():
        began = time.perf_counter()
        h, standard = recipe()
        took = time.perf_counter() - began
        smallest = None if standard is None else definiteness(standard)
        ways[name] = JudgedEstimate(
            parameters=h,
            rms_train=stack.rms(h),
            rms=other.rms(h),
            rms_above_boundary=fast.rms(h),
            feasible=None if smallest is None else bool(np.all(smallest > 0)),
            smallest_pseudo_inertia=smallest,
            from_estimate=float(np.linalg.norm(h - plain)),
            seconds=took,
        )
    return SetEstimates(float(np.linalg.cond(rows)), [len(t) for t in stack.tau], ways)
