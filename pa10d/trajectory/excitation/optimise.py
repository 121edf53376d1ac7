"""From a request to an exciting trajectory that can be run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.dynamics import Robot
from pa10d.trajectory.check import check
from pa10d.trajectory.excitation.criterion import Criterion
from pa10d.trajectory.excitation.feasible import (
    advice,
    refuse_hopeless,
    refuse_unexcited,
    refuse_unfit,
)
from pa10d.trajectory.excitation.mapping import as_mapper
from pa10d.trajectory.excitation.problem import ExcitationProblem
from pa10d.trajectory.excitation.result import ExcitationFigures, figures
from pa10d.trajectory.excitation.search import Found, Generation, search
from pa10d.trajectory.kinds.excitation import Excitation
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.plan import Plan
from pa10d.trajectory.poses import Surroundings

Array = NDArray[np.float64]

GENERATIONS = 25


@dataclass(frozen=True)
class ExcitingTrajectory:
    """request: ``{kind, parameters}`` with the coefficients."""

    request: Excitation
    plan: Plan
    figures: ExcitationFigures
    found: Found
    problem: ExcitationProblem

    def document(self) -> JsonObject:
        """For a YAML or JSON file: the request as it can be run, and what is known about it."""
        return {**self.request.request(), "about": self.about()}

    def about(self) -> JsonObject:
        """Figures and provenance."""
        return {
            **self.figures.document(),
            "seconds": round(self.found.seconds, 2),
            "generations": self.found.generations,
            "evaluations": self.found.evaluations,
            "finished": self.found.finished,
            "warnings": [
                *self.problem.limits.assumed,
                *advice(self.problem, self.found.x, self.figures),
            ],
        }


def exciting_trajectory(
    problem: ExcitationProblem,
    cycles: int = 3,
    generations: int = GENERATIONS,
    seed: int = 1,
    workers: Any = None,
    seconds: float | None = None,
    progress: Callable[[Generation], object] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
    refined: int = 4,
) -> ExcitingTrajectory:
    """The best trajectory that the search finds, checked against the robot's own limits.

    workers: None, a ``map``, an executor or a Dask client. Same seed and generations: same result.
    """
    refuse_hopeless(problem)
    found = search(
        problem, generations, seed, as_mapper(workers), seconds, progress, cancelled, refined
    )
    refuse_unfit(problem, found.x)
    refuse_unexcited(problem, found.x)
    request = Excitation.of(problem, found.x, cycles)
    around = Surroundings(problem.robot, problem.limits)
    plan = request.build(around)
    wrong = check(plan, problem.robot, limits_of(problem.robot))
    if wrong:
        raise UserError("\n".join(violation.sentence for violation in wrong))
    return ExcitingTrajectory(request, plan, figures(problem, found.x), found, problem)


def excitation_problem(
    robot: Robot,
    joints: list[int] | None = None,
    pose: list[float] | None = None,
    fundamental: float = 0.1,
    harmonics: int = 5,
    samples: int = 100,
    boundary: list[float] | None = None,
    noise: list[float] | None = None,
    **weights: Any,
) -> ExcitationProblem:
    """A problem from what a person says: joints from 1, boundary velocity and noise per chosen
    joint; weights: ``condition, smallest, evenness, determinant, above, scaled, second`` of
    Criterion."""
    base = Excitation(joints=joints, pose=pose)
    around = Surroundings.of(robot)
    chosen = base.chosen(around)

    def per_joint(key: str, values: list[float] | None) -> Array | None:
        if values is not None and len(values) != len(chosen):
            raise UserError(
                f"{key}: found {len(values)} values, expected {len(chosen)}, one per chosen joint"
            )
        return None if values is None else np.array(values)

    criterion = Criterion(
        boundary=per_joint("boundary", boundary), noise=per_joint("noise", noise), **weights
    )
    return ExcitationProblem(
        robot, tuple(chosen), tuple(base.home(around)), around.room, fundamental, harmonics,
        samples, criterion,
    )  # fmt: skip
