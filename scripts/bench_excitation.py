"""How good an exciting trajectory is found, and how fast: joints 1-4, all seven, another arm."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.common.parallel import process_map
from pa10d.dynamics import Robot, robot_from_urdf
from pa10d.services.robots import load_robot
from pa10d.trajectory.excitation.optimise import excitation_problem, exciting_trajectory
from pa10d.trajectory.excitation.problem import ExcitationProblem
from pa10d.trajectory.excitation.search import Generation

RANDOM = 60  # random motions that a search is compared with
TARGETS = ((45.0, 60.0), (40.0, 30.0))  # condition number within seconds, joints 1-4
ELSEWHERE = Path(__file__).resolve().parents[2] / "shared" / "data" / "ur10" / "robot.urdf"
CASES: tuple[tuple[str, list[int] | None, float], ...] = (
    ("pa10 joints 1-4", [1, 2, 3, 4], 30.0),
    ("pa10 all joints", None, 60.0),
)


def run(
    profile: str = "pa10-sim",
    seconds: float = 0.0,
    seed: int = 1,
    workers: int = 0,
    other_arm: str = "",
    only: str = "",
) -> dict[str, Any]:
    """Figures of each search.

    seconds: of every search, default 30 s for four joints and 60 s for whole arms; workers:
    processes, default one per processor; other_arm: the URDF of a further robot, default that of
    the test data where it is there; only: cases whose name contains this.
    """
    robot = load_robot(profile)[1]
    cases: list[tuple[str, Robot, list[int] | None, float]] = [
        (name, robot, joints, seconds or usual) for name, joints, usual in CASES
    ]
    further = Path(other_arm) if other_arm else ELSEWHERE
    if further.is_file():
        arm = robot_from_urdf(further, name=further.parent.name)
        cases.append((f"{arm.name} all joints", arm, None, seconds or 60.0))
    count = workers or len(os.sched_getaffinity(0))
    found = {
        name: _measured(excitation_problem(arm, joints), limit, seed, count)
        for name, arm, joints, limit in cases
        if only in name
    }
    return {
        "processors": len(os.sched_getaffinity(0)),
        "workers": count,
        "fundamental_hz": 0.1,
        "harmonics": 5,
        "samples": 100,
        "cases": found,
    }


def _measured(
    problem: ExcitationProblem, seconds: float, seed: int, workers: int
) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    chance = min(problem.condition_number(problem.random(rng)) for _ in range(RANDOM))
    reached: list[tuple[float, float]] = []

    def note(step: Generation) -> None:
        reached.append((step.seconds, step.condition_number))

    began = time.perf_counter()
    with process_map(workers) as mapper:
        result = exciting_trajectory(
            problem, generations=100_000, seed=seed, workers=mapper, seconds=seconds, progress=note
        )
    took = time.perf_counter() - began
    reached.append((took, result.figures.condition_number))
    keys = (
        "condition_number", "condition_number_model_base", "condition_number_scaled",
        "smallest_singular_value", "columns", "evenness",
    )  # fmt: skip
    return {
        **{key: getattr(result.figures, key) for key in keys},
        "seconds": took,
        "best_of_60_random": chance,
        "evaluations": result.found.evaluations,
        "evaluation_ms": 1e3 * took * workers / result.found.evaluations,
        "seconds_to": {
            f"{target:g}": next((at for at, value in reached if value <= target), None)
            for target, _ in TARGETS
        },
        "history": reached,
    }


def sentences(figures: dict[str, Any]) -> str:
    """For people."""
    lines = [f"{figures['workers']} processes; 5 harmonics of 0.1 Hz, 100 samples"]
    for name, found in figures["cases"].items():
        quick = {k: v for k, v in found["seconds_to"].items() if v is not None}
        reached = ", ".join(f"{target} after {at:.0f} s" for target, at in quick.items())
        lines.append(
            f"{name}: condition number {found['condition_number']:.1f} after "
            f"{found['seconds']:.0f} s{f' ({reached})' if reached else ''}; {found['columns']} "
            f"columns, {found['condition_number_model_base']:.1f} in the columns of models, "
            f"{found['condition_number_scaled']:.1f} scaled; best of {RANDOM} random motions "
            f"{found['best_of_60_random']:.0f}; {found['evaluations']} evaluations with gradient, "
            f"{found['evaluation_ms']:.2f} ms each"
        )
    return "\n".join(lines)
