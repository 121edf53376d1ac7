"""A candidate's gain and coefficients against the full least-squares problem with it inside."""

from __future__ import annotations

import numpy as np
import pytest
from bare_sides import bare_side, limits
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from pa10d.diagnose.regression.least_squares import least_squares
from pa10d.diagnose.regression.partial import bounded, partials

SIGMA = np.array([0.5, 2.0])
FREE = (-np.inf, np.inf)


def problem(seed: int, width: int = 4, samples: int = 200):
    """A side with the model's columns, and two candidate columns that the model half absorbs."""
    rng = np.random.default_rng(seed)
    side = bare_side([rng.standard_normal((samples, 2))])
    columns = {j: rng.standard_normal((samples, width)) for j in range(2)}
    candidate = {
        j: rng.standard_normal((samples, 2)) + columns[j] @ rng.standard_normal((width, 2))
        for j in range(2)
    }
    return side, columns, candidate


def squares(side, columns, lower=None, upper=None):
    """(least weighted squared error, coefficients), the last ones within bounds if given."""
    matrix = np.concatenate([columns[j] / SIGMA[j] for j in range(2)])
    target = np.concatenate([side.tau[j] / SIGMA[j] for j in range(2)])
    if lower is None:
        beta = np.linalg.lstsq(matrix, target, rcond=None)[0]
    else:
        free = matrix.shape[1] - len(lower)
        low = np.concatenate([np.full(free, -np.inf), lower])
        high = np.concatenate([np.full(free, np.inf), upper])
        beta = lsq_linear(matrix, target, (low, high), method="bvls", tol=1e-14).x
    return float(np.sum((target - matrix @ beta) ** 2)), beta


def joined(columns, candidate):
    return {j: np.column_stack([columns[j], candidate[j]]) for j in columns}


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_gain_is_the_drop_of_a_full_refit(seed):
    side, columns, candidate = problem(seed)
    fit = least_squares(side, columns, SIGMA)
    one = partials(fit, candidate, limits(FREE, FREE), 2)[0]
    before, _ = squares(side, columns)
    after, beta = squares(side, joined(columns, candidate))
    assert one.identifiable
    assert one.gain == pytest.approx(before - after, rel=1e-7, abs=1e-9)
    np.testing.assert_allclose(one.theta, beta[-2:], rtol=1e-6, atol=1e-10)
    moved = fit.beta - fit.to_beta @ (one.seen @ one.theta)  # the model makes room for it
    np.testing.assert_allclose(moved, beta[:-2], rtol=1e-6, atol=1e-10)


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_bounds_are_those_of_the_full_refit(seed):
    side, columns, candidate = problem(seed)
    fit = least_squares(side, columns, SIGMA)
    _, free = squares(side, joined(columns, candidate))
    lower, upper = np.array([-np.inf, free[-1] + 0.1]), np.array([free[-2] - 0.1, np.inf])
    effect = limits(*zip(lower, upper, strict=True))
    one = partials(fit, candidate, effect, 2)[0]
    before, _ = squares(side, columns)
    after, beta = squares(side, joined(columns, candidate), lower, upper)
    np.testing.assert_allclose(one.theta, beta[-2:], rtol=1e-5, atol=1e-8)
    assert one.gain == pytest.approx(before - after, rel=1e-5, abs=1e-7)


def test_a_column_in_one_joint_only():
    side, columns, candidate = problem(1)
    fit = least_squares(side, columns, SIGMA)
    alone = {1: candidate[1]}
    one = partials(fit, alone, limits(FREE, FREE), 2)[0]
    before, _ = squares(side, columns)
    whole = joined(columns, {0: np.zeros((200, 2)), 1: candidate[1]})
    after, _ = squares(side, whole)
    assert one.gain == pytest.approx(before - after)


def test_several_shapes_at_once_are_judged_one_by_one():
    side, columns, candidate = problem(2)
    fit = least_squares(side, columns, SIGMA)
    other = {j: c**3 for j, c in candidate.items()}
    effect = limits(FREE, (0.0, np.inf))
    both = partials(fit, joined(candidate, other), effect, 2)
    for one, columns_of in zip(both, (candidate, other), strict=True):
        alone = partials(fit, columns_of, effect, 2)[0]
        np.testing.assert_allclose(one.theta, alone.theta)
        assert one.gain == pytest.approx(alone.gain)


def test_what_the_model_absorbs_is_not_identifiable():
    side, columns, _ = problem(3)
    fit = least_squares(side, columns, SIGMA)
    rng = np.random.default_rng(0)
    inside = {j: c @ np.array([[1.0], [2.0], [0.0], [-1.0]]) for j, c in columns.items()}
    hardly = {j: c + 1e-3 * rng.standard_normal(c.shape) for j, c in inside.items()}
    empty = {j: np.zeros_like(c) for j, c in inside.items()}
    for absorbed in (inside, hardly, empty):
        one = partials(fit, absorbed, limits(FREE), 1)[0]
        assert not one.identifiable
        assert one.gain == 0.0
    visible = {j: c + 0.3 * rng.standard_normal(c.shape) for j, c in inside.items()}
    assert partials(fit, visible, limits(FREE), 1)[0].identifiable


def test_a_coefficient_without_a_column_stays_zero_and_the_others_count():
    side, columns, candidate = problem(4)
    fit = least_squares(side, columns, SIGMA)
    half = {j: c * np.array([1.0, 0.0]) for j, c in candidate.items()}
    one = partials(fit, half, limits(FREE, FREE), 2)[0]
    alone = partials(fit, {j: c[:, :1] for j, c in candidate.items()}, limits(FREE), 1)[0]
    assert one.identifiable
    assert one.gain == pytest.approx(alone.gain)
    np.testing.assert_allclose(one.theta, [alone.theta[0], 0.0])


@given(st.integers(0, 10_000), st.integers(1, 4))
@settings(max_examples=60, deadline=None)
def test_bounded_is_the_least_within_the_box(seed, size):
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((size + 3, size)) * 10.0 ** rng.uniform(-2, 2, size)
    gram, target = root.T @ root, rng.standard_normal(size + 3)
    assume(np.linalg.cond(root) < 1e6)
    rhs = root.T @ target
    centre = np.linalg.solve(gram, rhs)
    span = np.abs(centre) + 1e-6
    lower = np.where(rng.random(size) < 0.3, -np.inf, centre + span * rng.uniform(-1, 0.5, size))
    width = span * rng.uniform(0.1, 1.5, size)
    upper = np.where(rng.random(size) < 0.3, np.inf, np.maximum(lower, centre - span) + width)
    theta = bounded(gram, rhs, lower, upper)
    assert np.all(theta >= lower - 1e-9 * span)
    assert np.all(theta <= upper + 1e-9 * span)
    best = lsq_linear(root, target, (lower, upper), method="bvls", tol=1e-14).x

    def cost(x):
        return float(np.sum((root @ x - target) ** 2))

    assert cost(theta) <= cost(best) * (1 + 1e-7) + 1e-10
