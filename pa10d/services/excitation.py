"""Exciting trajectories: from a profile to a file that the daemon can run."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from pa10d.common.jsonable import JsonObject
from pa10d.common.parallel import process_map
from pa10d.services.robots import load_robot
from pa10d.trajectory.excitation.optimise import (
    GENERATIONS,
    ExcitingTrajectory,
    excitation_problem,
    exciting_trajectory,
)
from pa10d.trajectory.excitation.search import Generation

Progress = Callable[[float, str], None]
ENDLESS = 100_000  # generations, where the time is what ends the search


def excite(
    profile: str | os.PathLike[str],
    joints: Sequence[int] | None = None,
    *,
    seconds: float | None = None,
    generations: int | None = None,
    seed: int = 1,
    cycles: int = 3,
    workers: int | None = None,
    floor: float | str | None = None,
    progress: Progress | None = None,
    cancel: Callable[[], bool] | None = None,
    **problem: Any,
) -> ExcitingTrajectory:
    """Search for ``generations``, or for as long as ``seconds`` allow; ``problem``: options of
    ``excitation_problem`` (pose, fundamental, harmonics, samples, boundary, noise, …).

    floor: m or 'none', instead of the profile's.
    """
    robot = load_robot(profile)[1]
    if floor is not None:
        height = None if floor == "none" else float(floor)
        robot = replace(robot, environment=replace(robot.environment, floor=height))
    asked = excitation_problem(robot, None if joints is None else list(joints), **problem)
    rounds = generations if generations is not None else ENDLESS if seconds else GENERATIONS

    def tell(step: Generation) -> None:
        if progress is None:
            return
        share = step.seconds / seconds if seconds else step.generation / step.generations
        words = f"condition number {step.condition_number:.1f}, {step.evaluations} evaluations"
        progress(min(share, 1.0), words)

    with process_map(workers) as mapper:
        return exciting_trajectory(
            asked, cycles, rounds, seed, mapper, seconds, tell, cancel or (lambda: False)
        )


def excitation_document(
    profile: str, joints: Sequence[int] | None = None, **options: Any
) -> JsonObject:
    """The same as plain numbers, for a job of the daemon: ``{kind, parameters, about}``."""
    return excite(profile, joints, **options).document()
