"""The feasible parameters nearest to the weighted fit, and what feasibility costs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.dynamics.feasible import Feasible, feasible_fit
from pa10d.dynamics.pseudo_inertia import definiteness
from pa10d.dynamics.rotors import rotors_within
from pa10d.identify.fit import Fit
from pa10d.identify.prior import Beside
from pa10d.model import Unknowns
from pa10d.regression.layout import Layout
from pa10d.regression.solution import solve

Array = NDArray[np.float64]

AT_BOUND = 1e-6  # of a link's own size: its pseudo-inertia is singular
CONVERGED = 0.9  # of its cost: no possible arm can come below that


@dataclass(frozen=True)
class FeasibleModel:
    """standard (n, 10); rotors (n,) kg·m² (kg) of those that base parameters take in, zero
    elsewhere; coefficients of all effects within their bounds, in the layout's order; rms (n,) N·m
    over the fitted samples; edge (n,) True where a link is barely possible; converged: that nothing
    possible leaves notably less is certain."""

    standard: Array
    rotors: Array
    coefficients: Array
    rms: Array
    edge: NDArray[np.bool_]
    found: bool
    converged: bool


def find_feasible(fit: Fit, layout: Layout, known: Beside | None = None) -> FeasibleModel:
    """Least squares again, on the same weighted data and what is known besides, with every link a
    possible body."""
    solution, bodies = fit.solution, None
    if known is not None:  # of bodies themselves, not of what torque shows of them
        own = known.of_bodies()
        bodies = (own.rows, own.target)
        solution = solve(fit.factors, layout.of_joint, layout.size, solution.sigma, known.unknowns)
    return nearest_feasible(
        solution.triangle,
        solution.target,
        layout,
        layout.robot,
        lambda beta: fit.rms_of(beta, layout.of_joint),
        bodies,
    )


def nearest_feasible(
    triangle: Array,
    target: Array,
    unknowns: Unknowns,
    robot: Robot,
    rms: Callable[[Array], Array],
    bodies: tuple[Array, Array] | None = None,
) -> FeasibleModel:
    """The same of any weighted fit, ‖triangle·β - target‖²; rms: (n,) N·m that another β leaves;
    bodies: rows and target of what is known of standard parameters (10n,)."""
    base = unknowns.base
    bounded = [c for term in unknowns.terms for c in term.effect.coefficients]
    lower, upper = (np.array([getattr(c, side) for c in bounded]) for side in ("lower", "upper"))
    within = rotors_within(robot, base)
    answer: Feasible = feasible_fit(
        triangle, target, base, robot.parameters, lower, upper, bodies, within.share
    )
    inner, rotors = definiteness(answer.standard), np.zeros(robot.n)
    rotors[list(within.joints)] = answer.rotors
    h = base.of(answer.standard) + within.share @ answer.rotors
    return FeasibleModel(
        standard=answer.standard,
        rotors=rotors,
        coefficients=answer.extra,
        rms=rms(np.concatenate([h, answer.extra])),
        edge=inner < AT_BOUND,
        found=answer.found and bool(np.all(inner > 0)),
        converged=answer.least >= CONVERGED * answer.cost,
    )
