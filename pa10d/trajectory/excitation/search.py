"""Global search: a population of polished motions that are crossed, shifted and polished again.

Every generation is one call of a map-like function over independent tasks, drawn beforehand from
one generator: the result depends on the seed, never on the number of workers. Why not a plain
genetic algorithm or CMA-ES: docs/decisions/0080-exciting-trajectories.md.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.trajectory.excitation.in_the_open import narrower, open_pose
from pa10d.trajectory.excitation.polish import QUICK, THOROUGH, FeasibleMotion, judged, polish
from pa10d.trajectory.excitation.problem import ExcitationProblem

Array = NDArray[np.float64]
Mapper = Callable[[Callable[[Any], FeasibleMotion], Iterable[Any]], Iterable[FeasibleMotion]]

POPULATION = 12
BATCH = 8  # tasks of one generation
THOROUGHLY = 2.5  # generations that the last polish takes
SAME = 5e-4  # log cost within which two motions are taken as one
FAVOUR = 0.25  # of the geometric law by which better parents are preferred
NUDGE, JUMP, STRIDE = 0.05, 0.3, 0.7  # of a coefficient's natural size; of a difference


@dataclass(frozen=True)
class Generation:
    """After each generation: how far, how good."""

    generation: int
    generations: int
    condition_number: float
    evaluations: int
    seconds: float


@dataclass
class Found:
    """The best motion, and how it was come by. ``finished`` False: cancelled or out of time."""

    x: Array
    score: float
    generations: int
    evaluations: int
    seconds: float
    finished: bool
    history: list[float] = field(default_factory=list)


def search(
    problem: ExcitationProblem,
    generations: int = 25,
    seed: int = 1,
    mapper: Mapper = map,
    seconds: float | None = None,
    progress: Callable[[Generation], object] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
    refined: int = 4,
) -> Found:
    """The best motion of ``generations`` generations, or of as many as ``seconds`` allow; the
    best ``refined`` are polished thoroughly at the end.

    Same seed and number of generations, same result, whatever ``mapper`` is: the built-in map, an
    executor's, or a cluster's (see ``mapping``).
    """
    began = time.monotonic()
    rng = np.random.default_rng(seed)
    _warm(problem)
    drawn = [problem.random(rng) for _ in range(POPULATION)]
    first = list(_polished(problem, drawn, QUICK, mapper))
    if all(problem.excess(c.x) > 0.0 for c in first):
        about = open_pose(problem, rng)
        begun = [narrower(problem, x, about) for x in drawn]
        first += _polished(problem, begun, QUICK, mapper)
    count = sum(c.evaluations for c in first)
    people = sorted((_aligned(problem, c) for c in first), key=_score)[:POPULATION]
    history, done = [people[0].score], 0
    slowest = (time.monotonic() - began) * BATCH / POPULATION
    for done in range(1, generations + 1):
        if progress is not None:
            best = problem.condition_number(people[0].x)
            progress(Generation(done - 1, generations, best, count, time.monotonic() - began))
        spent = time.monotonic() - began
        if cancelled() or (seconds is not None and spent + (1 + THOROUGHLY) * slowest > seconds):
            done -= 1
            break
        children = [_child(problem, people, rng) for _ in range(BATCH)]
        for child in _polished(problem, children, QUICK, mapper):
            count += child.evaluations
            people = _with(people, _aligned(problem, child))
        history.append(people[0].score)
        slowest = max(slowest, time.monotonic() - began - spent)
    finished = done == generations
    late = seconds is not None and time.monotonic() - began > seconds
    final = [] if late or cancelled() else [c.x for c in people[:refined]]
    better = list(_polished(problem, final, THOROUGH, mapper))
    best_one = min([*better, *people], key=_score)
    count += sum(c.evaluations for c in better)
    took = time.monotonic() - began
    return Found(best_one.x, best_one.score, done, count, took, finished, history)


def _score(candidate: FeasibleMotion) -> float:
    return candidate.score


def _warm(problem: ExcitationProblem) -> None:
    """Let what is derived once be derived here, so that it travels with every task."""
    _ = (problem.bases, problem.capsules, problem.coarse, problem.scale, problem.room)


def _polished(
    problem: ExcitationProblem, motions: list[Array], stages: tuple, mapper: Mapper
) -> Iterator[FeasibleMotion]:
    return iter(mapper(polish, [(problem, x, stages) for x in motions]))


def _with(people: list[FeasibleMotion], child: FeasibleMotion) -> list[FeasibleMotion]:
    """The child replaces the worst, unless it is worse still or someone's twin."""
    if child.score >= people[-1].score or any(
        abs(child.score - other.score) < SAME for other in people
    ):
        return people
    return sorted([*people[:-1], child], key=_score)


def _child(
    problem: ExcitationProblem, people: list[FeasibleMotion], rng: np.random.Generator
) -> Array:
    """A good parent, changed in one of four ways."""
    one = people[min(int(rng.geometric(FAVOUR)) - 1, len(people) - 1)].x.copy()
    two, three = (people[int(k)].x for k in rng.integers(len(people), size=2))
    noise = problem.scale * rng.normal(size=problem.shape)
    way = int(rng.integers(4))
    if way == 0:  # some joints move as another parent's do
        swap = rng.random(problem.shape[1]) < 0.5
        one[:, swap] = two[:, swap]
        return one + NUDGE * noise
    if way == 1:
        return one + JUMP * noise
    if way == 2:  # one joint anew
        joint = int(rng.integers(problem.shape[1]))
        one[:, joint] = problem.random(rng)[:, joint]
        return one
    return one + STRIDE * (two - three)


def _aligned(problem: ExcitationProblem, candidate: FeasibleMotion) -> FeasibleMotion:
    """The same motion begun at another time: the first harmonic of the second joint starts as a
    sine. Only motions in step can be crossed; the cost hardly changes."""
    harmonics, joint = problem.harmonics, min(1, problem.shape[1] - 1)
    a, b = candidate.x[1 : 1 + harmonics], candidate.x[1 + harmonics :]
    order = np.arange(1, harmonics + 1)[:, None]
    phase = order * np.arctan2(b[0, joint], a[0, joint])
    c, s = np.cos(phase), np.sin(phase)
    x = np.vstack([candidate.x[:1], a * c + b * s, b * c - a * s])
    return judged(problem, x, candidate.evaluations)
