"""From any motion to the best one nearby: gradients of the smooth cost, limits as penalties."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.trajectory.excitation.problem import ExcitationProblem

Array = NDArray[np.float64]

QUICK = ((12.0, 3.0, 60), (30.0, 30.0, 50))  # sharpness, penalty, iterations: one after another
THOROUGH = ((30.0, 30.0, 200), (60.0, 100.0, 300))
UNFIT = 10.0  # log cost added per unit by which a limit is exceeded after all
EXACT = 1000.0  # sharpness at which a p-norm is the maximum


@dataclass(frozen=True)
class FeasibleMotion:
    """A motion within its limits: coefficients as ExcitationProblem.shape, and its log cost."""

    x: Array
    score: float
    evaluations: int


def polish(
    task: tuple[ExcitationProblem, Array, tuple[tuple[float, float, int], ...]],
) -> FeasibleMotion:
    """Improve one motion; the argument is one tuple so that any ``map`` can carry it."""
    problem, x, stages = task
    scale, evaluations = problem.scale, 0
    for sharpness, penalty, iterations in stages:

        def cost(
            z: Array, sharpness: float = sharpness, penalty: float = penalty
        ) -> tuple[float, Array]:
            value, grad = problem.cost(z.reshape(problem.shape) * scale, sharpness, penalty)
            return value, (grad * scale).ravel()

        found = scipy.optimize.minimize(
            cost,
            (x / scale).ravel(),
            jac=True,
            method="L-BFGS-B",
            options={"maxiter": iterations, "maxcor": 20},
        )
        x = found.x.reshape(problem.shape) * scale
        evaluations += int(found.nfev)
    return judged(problem, x, evaluations)


def judged(problem: ExcitationProblem, x: Array, evaluations: int) -> FeasibleMotion:
    """A motion brought within its limits, and what it is worth."""
    x = problem.repaired(x)
    score = problem.cost(x, EXACT, 0.0)[0] + UNFIT * problem.excess(x)
    return FeasibleMotion(x, float(score), evaluations)
