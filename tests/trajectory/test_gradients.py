"""Gradients against differences of what they are gradients of."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.dynamics import regressor
from pa10d.dynamics.adjoint import regressor_gradient
from pa10d.dynamics.base import random_motion
from pa10d.trajectory.excitation.criterion import Criterion
from pa10d.trajectory.excitation.problem import ExcitationProblem
from tests.trajectory.sample_arms import pa10, random_tree


@pytest.mark.parametrize("seed", range(6))
def test_gradient_of_the_regressor_on_random_trees(seed):
    robot = random_tree(5, seed)
    motion = random_motion(robot, 4, seed)
    rng = np.random.default_rng(seed)
    columns = np.sort(rng.choice(50, 23, replace=False))
    weights = rng.normal(size=(4, 5, 23))
    found = regressor_gradient(robot, *motion, weights, columns)

    def total(parts):
        return np.sum(weights * regressor(robot, *parts, columns), axis=(1, 2))

    for which in range(3):
        for joint in range(5):
            step = np.zeros(5)
            step[joint] = 1e-6
            up, down = ([*motion], [*motion])
            up[which], down[which] = motion[which] + step, motion[which] - step
            wanted = (total(up) - total(down)) / 2e-6
            assert found[which][:, joint] == pytest.approx(wanted, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize(
    "criterion",
    [
        Criterion(),
        Criterion(second=0.0),
        Criterion(1.0, 2.0, 3.0),
        Criterion(scaled=True, noise=np.array([1.0, 2.0, 0.5, 3.0])),
        Criterion(boundary=np.array([0.25, 0.27, 0.3, 0.6])),
        Criterion(boundary=np.array([0.25, 0.27, 0.3, 0.6]), above=0.4),
        Criterion(determinant=True),
    ],
    ids=["cond", "one base", "even", "scaled and weighed", "boundary", "both", "determinant"],
)
def test_gradient_of_the_cost(criterion):
    problem = ExcitationProblem.of(pa10(), (0, 1, 2, 3), criterion=criterion)
    rng = np.random.default_rng(2)
    x = problem.random(rng) * 1.2  # beyond its limits, so that penalties act
    x[0] += 0.3
    _, gradient = problem.cost(x, 8.0, 10.0)
    for _ in range(3):
        way = rng.normal(size=x.shape) * problem.scale
        step = 1e-6
        ahead, behind = (problem.cost(x + s * way, 8.0, 10.0)[0] for s in (step, -step))
        wanted = (ahead - behind) / (2 * step)
        assert np.sum(gradient * way) == pytest.approx(wanted, rel=2e-5)


def test_a_sharp_cost_is_the_condition_number_itself():
    problem = ExcitationProblem.of(pa10(), (0, 1, 2, 3), criterion=Criterion(second=0.0))
    x = problem.random(np.random.default_rng(1))
    cost = problem.cost(x, 2000.0, 0.0)[0]
    values = np.linalg.svd(problem.observation(x), compute_uv=False)
    assert np.exp(cost) == pytest.approx(values[0] / values[-1], rel=5e-3)


def test_lambda_weighs_condition_and_smallest_singular_value():
    problem = ExcitationProblem.of(pa10(), (0, 1, 2, 3), criterion=Criterion(2.0, 5.0, second=0.0))
    x = problem.random(np.random.default_rng(1))
    values = np.linalg.svd(problem.observation(x), compute_uv=False)
    wanted = 2.0 * values[0] / values[-1] + 5.0 / values[-1]
    assert np.exp(problem.cost(x, 2000.0, 0.0)[0]) == pytest.approx(wanted, rel=5e-3)
