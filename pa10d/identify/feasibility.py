"""The feasible parameters nearest to the weighted fit, and what feasibility costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.feasible import Feasible, feasible_fit
from pa10d.dynamics.pseudo_inertia import definiteness
from pa10d.identify.fit import Fit
from pa10d.identify.layout import Layout

Array = NDArray[np.float64]

AT_BOUND = 1e-6  # of a link's own size: its pseudo-inertia is singular


@dataclass(frozen=True)
class FeasibleModel:
    """standard (n, 10); coefficients of all effects within their bounds, in the layout's order;
    rms (n,) N·m over the fitted samples; edge (n,) True where a link is barely possible."""

    standard: Array
    coefficients: Array
    rms: Array
    edge: NDArray[np.bool_]
    found: bool


def find_feasible(fit: Fit, layout: Layout) -> FeasibleModel:
    """Least squares again, on the same weighted data, with every link a possible body."""
    lower = np.array([c.lower for s in layout.slots for c in s.effect.coefficients])
    upper = np.array([c.upper for s in layout.slots for c in s.effect.coefficients])
    solution = fit.solution
    answer: Feasible = feasible_fit(
        solution.triangle, solution.target, layout.base, layout.robot.parameters, lower, upper
    )
    beta = np.concatenate([layout.base.of(answer.standard), answer.extra])
    inner = definiteness(answer.standard)
    return FeasibleModel(
        standard=answer.standard,
        coefficients=answer.extra,
        rms=fit.rms_of(beta, layout.of_joint),
        edge=inner < AT_BOUND,
        found=answer.found and bool(np.all(inner > 0)),
    )
