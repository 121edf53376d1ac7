"""Weighted least squares and its downdate against numpy's on the same numbers."""

from __future__ import annotations

import numpy as np
import pytest
from bare_sides import bare_side, stacked
from hypothesis import given, settings
from hypothesis import strategies as st

from pa10d.diagnose.regression.least_squares import LeastSquares, iterated_fit, least_squares
from pa10d.regression.problem import Knowledge

SIGMA = np.array([0.5, 2.0, 1.0])


def problem(seed: int, width: int, samples: int = 120, joints: int = 3):
    """A side, columns per joint (m_j, width) of very different sizes, and masks that differ."""
    rng = np.random.default_rng(seed)
    keep = [rng.random((samples, joints)) < 0.8 for _ in range(2)]
    side = bare_side([rng.standard_normal((samples, joints)) for _ in range(2)], keep)
    size = 10.0 ** rng.uniform(-3, 3, width)
    columns = {
        j: rng.standard_normal((len(side.tau[j]), width)) * size * (rng.random(width) < 0.8)
        for j in range(joints)
    }
    columns[0] += 1e-3 * size * rng.standard_normal((len(side.tau[0]), width))  # none is empty
    return side, columns


def by_numpy(side, columns, sigma, mean=None, root=None):
    """Coefficients and weighted residual per joint from one dense least-squares problem."""
    matrix = np.concatenate([columns[j] / sigma[j] for j in range(side.n)])
    target = np.concatenate([side.tau[j] / sigma[j] for j in range(side.n)])
    rows = len(target)
    if mean is not None:
        known = np.zeros((len(root), matrix.shape[1]))
        known[:, : len(mean)] = root
        matrix = np.concatenate([matrix, known])
        target = np.concatenate([target, root @ mean])
    scale = np.linalg.norm(matrix, axis=0)
    beta = np.linalg.lstsq(matrix / scale, target, rcond=None)[0] / scale
    return beta, (target - matrix @ beta)[:rows]


@given(st.integers(0, 10_000), st.integers(1, 12))
@settings(max_examples=20, deadline=None)
def test_weighted_fit_is_least_squares(seed, width):
    side, columns = problem(seed, width)
    fit = least_squares(side, columns, SIGMA)
    beta, residual = by_numpy(side, columns, SIGMA)
    np.testing.assert_allclose(fit.beta, beta, rtol=1e-7, atol=1e-9 * np.abs(beta).max())
    np.testing.assert_allclose(stacked(fit.residual), residual, atol=1e-9)
    assert fit.rank == width
    matrix = np.concatenate([columns[j] / SIGMA[j] for j in range(3)])
    scale = np.linalg.norm(matrix, axis=0)
    inverse = np.linalg.inv((matrix / scale).T @ (matrix / scale)) / np.outer(scale, scale)
    np.testing.assert_allclose(fit.covariance(), inverse, rtol=1e-6, atol=1e-9 * inverse.max())


def test_the_triangular_form_is_the_whole_problem():
    """What any other coefficients leave, but for what none explains; prior knowledge included."""
    side, columns = problem(5, 6)
    mean, root = np.arange(3.0), np.diag([1.0, 20.0, 300.0])
    fit = least_squares(side, columns, SIGMA, Knowledge.about(mean, root))
    rng = np.random.default_rng(6)

    def squares(beta):
        left = sum(np.sum(((side.tau[j] - columns[j] @ beta) / SIGMA[j]) ** 2) for j in range(3))
        return left + np.sum((root @ (beta[:3] - mean)) ** 2)

    def by_triangle(beta):
        return np.sum((fit.triangle @ beta - fit.target) ** 2)

    least = squares(fit.beta) - by_triangle(fit.beta)
    for _ in range(5):
        other = fit.beta * rng.uniform(0.5, 1.5, 6)
        assert by_triangle(other) + least == pytest.approx(squares(other), rel=1e-9)


@given(st.integers(0, 10_000), st.integers(2, 10), st.data())
@settings(max_examples=20, deadline=None)
def test_without_equals_a_refit_without_the_columns(seed, width, data):
    first = data.draw(st.integers(0, width - 1))
    last = data.draw(st.integers(first + 1, width))
    if first == 0 and last == width:
        last -= 1
    side, columns = problem(seed, width)
    out = slice(first, last)
    short = least_squares(side, columns, SIGMA).without(out)
    rest = {j: np.delete(c, out, axis=1) for j, c in columns.items()}
    again = least_squares(side, rest, SIGMA)
    np.testing.assert_allclose(stacked(short.residual), stacked(again.residual), atol=1e-8)
    np.testing.assert_allclose(np.delete(short.beta, out), again.beta, rtol=1e-6, atol=1e-12)
    size = np.linalg.norm(np.concatenate([columns[j] for j in range(side.n)]), axis=0)
    target = np.linalg.norm(np.concatenate([side.tau[j] for j in range(side.n)]))
    assert np.all(np.abs(short.beta[out]) * size[out] < 1e-12 * target)
    _same_span(short, again)
    kept = np.delete(np.arange(width), out)
    np.testing.assert_allclose(
        short.covariance()[np.ix_(kept, kept)], again.covariance(), rtol=1e-5, atol=1e-14
    )


def _same_span(one: LeastSquares, other: LeastSquares) -> None:
    """What either basis absorbs of any vector is the same."""
    rng = np.random.default_rng(0)
    vector = {j: rng.standard_normal(len(q)) for j, q in one.basis.items()}
    absorbed = [
        stacked({j: f.basis[j] @ sum(f.basis[i].T @ v for i, v in vector.items()) for j in vector})
        for f in (one, other)
    ]
    np.testing.assert_allclose(absorbed[0], absorbed[1], atol=1e-8)


def test_a_repeated_column_changes_nothing_but_the_rank():
    side, columns = problem(3, 5)
    twice = {j: np.column_stack([c, 7.0 * c[:, 2]]) for j, c in columns.items()}
    fit, again = least_squares(side, columns, SIGMA), least_squares(side, twice, SIGMA)
    assert again.rank == fit.rank == 5
    np.testing.assert_allclose(stacked(again.residual), stacked(fit.residual), atol=1e-9)
    np.testing.assert_allclose(again.beta[2] + 7.0 * again.beta[5], fit.beta[2], rtol=1e-9)


def nearly_twins():
    """A side, and four columns of which two differ by 1e-6: near null, and no rounding."""
    side, _ = problem(8, 4)
    rng = np.random.default_rng(9)
    columns = {j: rng.standard_normal((len(side.tau[j]), 4)) for j in range(3)}
    for c in columns.values():
        c[:, 2] = c[:, 1] + 1e-6 * c[:, 2]
    return side, columns


def test_a_near_null_direction_is_solved_for_where_the_data_ask_for_it():
    """As identification does: a base joint beside light wrists had its inertia truncated, and a
    search that found the right friction elsewhere left it at three times its floor."""
    side, columns = nearly_twins()
    assert least_squares(side, columns, SIGMA).rank == 3  # noise asks for nothing
    for j, c in columns.items():
        side.tau[j] += 3e6 * (c[:, 2] - c[:, 1])
    fit = least_squares(side, columns, SIGMA)
    assert fit.rank == 4
    assert fit.beta[2] - fit.beta[1] == pytest.approx(6e6, rel=0.1)


def test_a_near_null_direction_that_is_known_beforehand_stays_where_it_is_known_to_be():
    side, columns = nearly_twins()
    known = Knowledge.about(np.array([0.0, 2e4, -2e4]), np.diag([0.0, 1e-4, 1e-4]))
    fit = least_squares(side, columns, SIGMA, known)
    assert fit.rank == 4  # the data alone would be wrong by 5e4
    assert fit.beta[2] - fit.beta[1] == pytest.approx(-4e4, abs=2e4)


def test_leaving_out_a_column_beside_twins_equals_a_refit():
    side, columns = problem(4, 5)
    twins = {j: np.column_stack([c, 3.0 * c[:, 1]]) for j, c in columns.items()}
    short = least_squares(side, twins, SIGMA).without(slice(3, 4))
    again = least_squares(side, {j: np.delete(c, 3, axis=1) for j, c in twins.items()}, SIGMA)
    np.testing.assert_allclose(stacked(short.residual), stacked(again.residual), atol=1e-9)
    _same_span(short, again)


def test_leaving_out_a_column_beside_zeros_equals_a_refit():
    side, columns = problem(7, 5)
    empty = {j: np.insert(c, 4, 0.0, axis=1) for j, c in columns.items()}
    fit = least_squares(side, empty, SIGMA)
    assert fit.beta[4] == 0.0
    assert fit.covariance()[4, 4] == 0.0
    short = fit.without(slice(3, 5))
    again = least_squares(side, {j: np.delete(c, 3, axis=1) for j, c in columns.items()}, SIGMA)
    np.testing.assert_allclose(stacked(short.residual), stacked(again.residual), atol=1e-9)
    _same_span(short, again)


def test_a_prior_counts_as_so_many_equations():
    rng = np.random.default_rng(5)
    side, columns = problem(5, 6)
    mean, root = rng.standard_normal(4), rng.standard_normal((4, 4))
    fit = least_squares(side, columns, SIGMA, Knowledge.about(mean, root))
    beta, residual = by_numpy(side, columns, SIGMA, mean, root)
    np.testing.assert_allclose(fit.beta, beta, rtol=1e-6)
    np.testing.assert_allclose(stacked(fit.residual), residual, atol=1e-8)


def test_a_certain_prior_keeps_the_model_where_it_is():
    side, columns = problem(6, 6)
    mean = np.arange(6.0)
    fit = least_squares(side, columns, SIGMA, Knowledge.about(mean, 1e9 * np.eye(6)))
    np.testing.assert_allclose(fit.beta, mean, atol=1e-6)


def test_iterated_fit_finds_each_joints_own_noise():
    rng = np.random.default_rng(7)
    truth = np.array([0.1, 1.0, 8.0])
    side = bare_side([rng.standard_normal((2000, 3)) * truth])
    columns = {j: rng.standard_normal((2000, 4)) for j in range(3)}
    fit = iterated_fit(side, columns)
    np.testing.assert_allclose(fit.sigma, truth, rtol=0.06)
    np.testing.assert_allclose(fit.rms(), truth, rtol=0.06)
    flat = least_squares(side, columns, np.ones(3))
    assert np.linalg.norm(fit.beta) < 0.5 * np.linalg.norm(flat.beta)  # truth is zero


def test_rms_is_in_newton_metres():
    side, columns = problem(8, 3)
    fit = least_squares(side, columns, SIGMA)
    plain = [side.tau[j] - columns[j] @ fit.beta for j in range(3)]
    assert fit.rms() == pytest.approx([np.sqrt(np.mean(r**2)) for r in plain])
