"""How stiff a map is drawn: as rough as the truth, and flat where there is only noise."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.diagnose.asked.stiffness import NormalEquations, stiffness

K, ROWS = 20, 3000


def problem(seed: int, truth: np.ndarray, noise: float) -> tuple[NormalEquations, np.ndarray]:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(ROWS, K))
    y = x @ truth + noise * rng.normal(size=ROWS)
    steps = np.diff(np.eye(K), axis=0)
    penalty = steps.T @ steps + 1e-3 * np.eye(K)
    return NormalEquations(x.T @ x, x.T @ y, float(y @ y), ROWS, penalty), y


def unlikelihood(found: NormalEquations, ratio: float) -> float:
    """-2 log of the probability of the data where coefficients are drawn as the penalty says,
    written down without any decomposition; the noise's variance at its best."""
    inside = found.gram + ratio * found.penalty
    left = found.power - found.rhs @ np.linalg.solve(inside, found.rhs)
    logs = np.linalg.slogdet(inside)[1] - np.linalg.slogdet(ratio * found.penalty)[1]
    return float(found.rows * np.log(left) + logs)


@pytest.mark.parametrize("noise", [0.3, 3.0])
def test_it_is_the_most_likely_one(noise):
    truth = np.cumsum(np.random.default_rng(5).normal(size=K))
    given, _ = problem(1, truth - truth.mean(), noise)
    found = stiffness(given, 1.0)
    here = unlikelihood(given, found.ratio)
    for factor in (0.1, 0.5, 2.0, 10.0):
        assert unlikelihood(given, factor * found.ratio) > here
    assert found.variance == pytest.approx(noise**2, rel=0.1)
    # the variance of the steps of the truth is 1
    assert found.variance / found.ratio == pytest.approx(1.0, rel=0.8)


def test_the_map_solves_the_penalised_equations():
    given, _ = problem(2, np.sin(np.arange(K)), 1.0)
    found = stiffness(given, 1.0)
    inside = given.gram + found.ratio * given.penalty
    np.testing.assert_allclose(inside @ found.theta, given.rhs, rtol=1e-8, atol=1e-8)
    assert found.freedom == pytest.approx(np.trace(np.linalg.solve(inside, given.gram)))


def test_noise_alone_is_drawn_flat():
    freedom = [stiffness(problem(s, np.zeros(K), 1.0)[0], 1.0).freedom for s in range(20)]
    assert np.median(freedom) < 1.0
    assert max(freedom) < 8.0


def test_samples_that_say_the_same_count_once():
    """Every row ten times: with that said, the same answer; without, a rougher one."""
    given, _ = problem(3, np.zeros(K), 1.0)
    tenfold = NormalEquations(
        10 * given.gram, 10 * given.rhs, 10 * given.power, 10 * given.rows, given.penalty
    )
    once, said = stiffness(given, 1.0), stiffness(tenfold, 10.0)
    assert said.freedom <= once.freedom + 0.5
    assert said.variance == pytest.approx(once.variance, rel=0.02)
