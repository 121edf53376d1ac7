"""The search for exciting trajectories."""

from __future__ import annotations

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.common.parallel import process_map
from pa10d.dynamics.observation import condition_number
from pa10d.trajectory.check import check
from pa10d.trajectory.excitation.criterion import Criterion
from pa10d.trajectory.excitation.mapping import as_mapper
from pa10d.trajectory.excitation.optimise import excitation_problem, exciting_trajectory
from pa10d.trajectory.excitation.polish import QUICK, judged, polish
from pa10d.trajectory.excitation.problem import CLEAR
from pa10d.trajectory.excitation.search import search
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.limits import limits_of
from tests.trajectory.sample_arms import among, around_pa10, pa10

FOUR = [1, 2, 3, 4]


@pytest.fixture(scope="module")
def small():
    """The first population, its best one refined: some seconds."""
    problem = excitation_problem(pa10(), FOUR)
    return exciting_trajectory(problem, generations=0, seed=3, refined=1)


@pytest.mark.long
def test_a_small_search_is_far_better_than_chance(small):
    problem = small.problem
    rng = np.random.default_rng(0)
    chance = min(problem.condition_number(problem.random(rng)) for _ in range(60))
    assert small.figures.condition_number < 50.0
    assert small.figures.condition_number < 0.8 * chance
    assert small.figures.columns == 32


@pytest.mark.long
def test_the_figures_are_those_of_the_plan_that_runs(small):
    """From the plan's own samples, over one of its periods, not from the optimiser's matrices."""
    plan = read_request(small.document()).build(around_pa10())
    span = plan.spans[0]
    q, dq, ddq = (part[:, :4] for part in plan.at(span.begin + np.arange(100) * 0.1))
    found = condition_number(small.problem.arm, q, dq, ddq)
    assert found == pytest.approx(small.figures.condition_number, rel=1e-9)
    again = plan.at(span.begin + 10.0 + np.arange(100) * 0.1)[0][:, :4]
    assert again == pytest.approx(q, abs=1e-9)


def test_the_plan_keeps_every_limit_and_rests_at_both_ends(small):
    robot, limits = pa10(), limits_of(pa10())
    assert check(small.plan, robot, limits) == []
    samples = small.plan.sample(1000.0)
    assert np.abs(samples.dq[[0, -1]]).max() < 1e-9
    assert np.all(samples.q.min(axis=0) >= limits.lower)
    assert np.all(samples.q.max(axis=0) <= limits.upper)
    assert np.all(np.abs(samples.dq).max(axis=0) <= limits.velocity)
    assert np.all(np.abs(samples.ddq).max(axis=0) <= limits.acceleration)
    begin, end = small.plan.segments[0].motion.steady
    steady = samples.q[(samples.t >= begin) & (samples.t <= end)]
    assert around_pa10().capsules.clearance(steady).min() >= CLEAR - 1e-3


@pytest.fixture(scope="module")
def problem():
    return excitation_problem(pa10(), [3, 4], harmonics=2, samples=40)


@pytest.fixture(scope="module")
def one(problem):
    """What a search finds by itself."""
    return search(problem, 1, 5, refined=1)


@pytest.mark.long
def test_same_seed_same_result_whoever_evaluates(problem, one):
    with ThreadPoolExecutor(3) as pool:
        other = search(problem, 1, 5, as_mapper(pool), refined=1)
    assert np.array_equal(one.x, other.x)
    assert one.evaluations == other.evaluations
    assert not np.array_equal(one.x, search(problem, 1, 6, refined=1).x)


@pytest.mark.long
@pytest.mark.parametrize(
    "processes", [False, pytest.param(True, marks=pytest.mark.long)], ids=["threads", "processes"]
)
def test_dask_evaluates_as_well(problem, one, processes):
    distributed = pytest.importorskip("distributed", reason="Dask's distributed is not installed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=processes, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        there = search(problem, 1, 5, as_mapper(client), refined=1)
    assert np.array_equal(there.x, one.x)


class PretendClient:
    """A client as Dask's: map gives futures in any order of completion, gather waits for them."""

    def __init__(self, pool):
        self.pool, self.calls = pool, 0

    def map(self, function, tasks, pure):
        assert pure is False
        self.calls += 1
        return [self.pool.submit(function, task) for task in tasks]

    def gather(self, futures):
        return [future.result() for future in futures]


@pytest.mark.long
def test_a_client_with_map_and_gather_is_a_map(problem, one):
    with ThreadPoolExecutor(2) as pool:
        client = PretendClient(pool)
        there = search(problem, 1, 5, as_mapper(client), refined=1)
    assert client.calls == 3  # the first population, a generation, the refinement
    assert np.array_equal(there.x, one.x)


def test_progress_is_told_and_cancelling_keeps_the_best_so_far():
    problem, told = excitation_problem(pa10(), [3, 4], harmonics=2, samples=40), []
    found = search(problem, 5, 1, progress=told.append, cancelled=lambda: len(told) >= 3)
    assert [step.generation for step in told] == [0, 1, 2]
    assert told[2].evaluations > told[1].evaluations > 0
    assert not found.finished
    assert found.generations == 2
    assert problem.excess(found.x) == 0.0


def test_time_is_kept(monkeypatch):
    """By a clock that goes on with the work alone."""
    problem, now = excitation_problem(pa10(), [3, 4], harmonics=2, samples=40), [0.0]

    def timed(_, tasks):
        for one, x, stages in tasks:
            now[0] += 0.1 if stages is QUICK else 0.5
            yield judged(one, x, 1)

    clock = SimpleNamespace(monotonic=lambda: now[0])
    monkeypatch.setattr(sys.modules[search.__module__], "time", clock)
    found = search(problem, 100_000, 1, timed, seconds=10.0)
    assert 8.0 < now[0] <= 10.0
    assert 0 < found.generations < 100
    assert not found.finished


def test_polishing_never_makes_a_motion_worse_and_repairs_it():
    problem = excitation_problem(pa10(), FOUR)
    rng = np.random.default_rng(8)
    for _ in range(3):
        x = problem.random(rng)
        better = polish((problem, x * 1.5, QUICK))
        assert problem.condition_number(better.x) < problem.condition_number(x)
        q, dq, ddq = (basis @ better.x for basis in problem.fine)
        assert np.all(np.abs(dq) <= problem.room.velocity * (1 + 1e-9))
        assert np.all(np.abs(ddq) <= problem.room.acceleration * (1 + 1e-9))
        assert np.all(q >= problem.room.lower - 1e-9)
        assert np.all(q <= problem.room.upper + 1e-9)


def polished(criterion, seed=4):
    problem = replace(excitation_problem(pa10(), FOUR), criterion=criterion)
    rng = np.random.default_rng(seed)
    best = min(
        (polish((problem, problem.random(rng), QUICK)) for _ in range(3)), key=lambda c: c.score
    )
    return replace(problem, criterion=Criterion()), best.x


def figure(problem, x, name):
    from pa10d.trajectory.excitation.result import figures

    return getattr(figures(problem, x), name)


@pytest.mark.long
def test_what_is_asked_for_is_what_gets_better():
    plain = polished(Criterion())
    smallest = polished(Criterion(condition=0.0, smallest=1.0))
    determinant = polished(Criterion(determinant=True))
    even = polished(Criterion(condition=0.0, evenness=1.0))
    scaled = polished(Criterion(scaled=True))
    assert figure(*smallest, "smallest_singular_value") > figure(*plain, "smallest_singular_value")
    assert figure(*determinant, "log_det") > figure(*plain, "log_det")
    assert max(figure(*even, "standard_error")) < max(figure(*plain, "standard_error"))
    assert figure(*scaled, "condition_number_scaled") < figure(*plain, "condition_number_scaled")


@pytest.mark.long
def test_a_boundary_velocity_makes_the_fast_samples_count():
    boundary = np.array([0.25, 0.27, 0.3, 0.6])
    plain, x = polished(Criterion())
    told, y = polished(Criterion(boundary=boundary))
    judged = Criterion(boundary=boundary)
    key = "condition_number_above_boundary"
    with_it = figure(replace(told, criterion=judged), y, key)
    without = figure(replace(plain, criterion=judged), x, key)
    assert with_it < without


def narrow(**changes):
    robot = pa10()
    parts = {}
    for name, (joint, value) in changes.items():
        parts[name] = getattr(robot, name).copy()
        parts[name][joint - 1] = value
    return replace(robot, **parts)


@pytest.mark.parametrize(
    ("robot", "options", "words"),
    [
        ({}, {"samples": 6}, "samples: 6 in a period give 24 equations for 32 parameters"),
        ({"lower": (3, -0.05), "upper": (3, 0.05)}, {}, "joint 3: may move by 0.04 rad only"),
        ({"velocity": (4, 0.001)}, {}, "joint 4: its limits of 0.0009"),
        ({"effort": (2, 1.0)}, {}, "joint 2: gravity alone asks for"),
        ({"floor": 1.2}, {}, "link 5 and the floor come nearer than 0.03 m in 100 % of all poses"),
        ({}, {"pose": [0, 1.5, 0, 1.5, 0, 0, 0], "joints": [5, 6]}, "and the floor come nearer"),
    ],
)
def test_what_cannot_be_is_refused_before_the_search(monkeypatch, robot, options, words):
    asked = {"joints": FOUR, **options}
    narrowed = narrow(**{key: value for key, value in robot.items() if key != "floor"})
    arm = among(narrowed, floor=robot.get("floor", 0.0))
    monkeypatch.setattr("pa10d.trajectory.excitation.optimise.search", None)
    with pytest.raises(UserError) as caught:
        exciting_trajectory(excitation_problem(arm, **asked), generations=0)
    assert words in str(caught.value)
    assert "expected" in str(caught.value)


@pytest.mark.long
def test_a_joint_that_is_hardly_excited_is_named_after_the_search():
    found = exciting_trajectory(
        excitation_problem(narrow(lower=(3, -0.07), upper=(3, 0.07)), [3, 4]),
        generations=0,
        refined=0,
    )
    assert any("joint 3 is held back by its position limit" in w for w in found.about()["warnings"])
    with pytest.raises(
        UserError, match=r"can hardly be seen .* joint 4 is held back by its velocity"
    ):
        exciting_trajectory(
            excitation_problem(narrow(velocity=(4, 0.0115)), [3, 4]), generations=0, refined=0
        )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"joints": [1, 9]}, "joints: found 9"),
        ({"joints": FOUR, "boundary": [0.1]}, "boundary: found 1 values, expected 4"),
        ({"joints": FOUR, "noise": [0.1] * 7}, "noise: found 7 values, expected 4"),
    ],
)
def test_a_wrong_request_is_one_line(options, words):
    with pytest.raises(UserError, match=words):
        excitation_problem(pa10(), **options)


@pytest.mark.long
def test_joints_1_to_4_below_45_within_a_minute_on_two_cores():
    problem = excitation_problem(pa10(), FOUR)
    with process_map(min(2, os.cpu_count() or 1)) as mapper:
        found = exciting_trajectory(problem, generations=100_000, workers=mapper, seconds=60.0)
    assert found.found.seconds < 65.0
    assert found.figures.condition_number <= 45.0


@pytest.mark.long
def test_all_seven_joints():
    with process_map(2) as mapper:
        found = exciting_trajectory(
            excitation_problem(pa10()), generations=100_000, workers=mapper, seconds=60.0
        )
    assert found.figures.columns == 62
    assert found.figures.condition_number <= 200.0
