"""What an answer depends on."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.identify.jackknife import STRETCHES, moved_by_stretches, stretches, without_each
from pa10d.identify.rows import Rows, triangles_of


def rows(count: int, seed: int = 0) -> Rows:
    rng = np.random.default_rng(seed)
    every = np.ones((count, 2), dtype=bool)
    columns = [rng.normal(size=(count, 3)), rng.normal(size=(count, 4))]
    return Rows(columns, rng.normal(size=(count, 2)), every, ~every)


def mean_of_first(triangles) -> float:
    return float(triangles[0].sums[-1] / triangles[0].rows)


@pytest.mark.parametrize("count", [1, 2, 4, 9])
def test_stretches_are_all_of_the_data_and_each_is_left_out_once(count):
    pieces = [rows(60 + k, k) for k in range(count)]
    parts = stretches(pieces)
    assert len(parts) >= STRETCHES
    every = triangles_of(pieces)
    seen = []
    without_each(pieces, lambda rest: float(len(seen) if seen.append(rest) else 0))
    assert len(seen) == len(parts)
    for part, rest in zip(parts, seen, strict=True):
        for own, others, all_of_it in zip(triangles_of([part]), rest, every, strict=True):
            assert own.rows + others.rows == all_of_it.rows
            np.testing.assert_allclose(own.sums + others.sums, all_of_it.sums, atol=1e-9)
            together = own.r.T @ own.r + others.r.T @ others.r
            np.testing.assert_allclose(together, all_of_it.r.T @ all_of_it.r, atol=1e-9)


def test_of_a_mean_it_is_the_standard_error_of_a_mean():
    """With one sample a stretch, exactly."""
    part = rows(STRETCHES, 3)
    found = moved_by_stretches(without_each([part], mean_of_first))
    values = part.tau[:, 0]
    assert found == pytest.approx(values.std(ddof=1) / np.sqrt(len(values)))


def test_where_the_rest_has_no_answer_nothing_is_known_of_it():
    assert moved_by_stretches(np.array([np.nan, 1.0, np.nan])) == 0.0
    assert moved_by_stretches(np.array([1.0, np.nan, 3.0])) == pytest.approx(1.0)
