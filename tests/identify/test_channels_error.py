"""How sure a torque channel's time is, from how well the delays beside it suit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pa10d.identify.channel import _vertex

SPREAD = st.floats(0.05, 1.0)


@given(st.floats(-0.9, 0.9), st.floats(0.01, 3.0), SPREAD, SPREAD)
def test_of_a_parabola_it_is_where_that_has_fallen_by_one(top, error, left, right):
    """Its middle is the best of what was tried, wherever its top lies."""
    tried = [1.0 - left, 1.0, 1.0 + right]
    top = 1.0 + 0.5 * top * min(left, right)
    known = {d: np.array([5.0 - ((d - top) / error) ** 2]) for d in tried}
    times, found = _vertex(known, 1.0)
    assert times == pytest.approx(top, abs=1e-6)
    assert found == pytest.approx(error, rel=1e-6)


@pytest.mark.parametrize("likelihood", [0.0, 20.0, 1e9])
def test_where_all_suit_alike_nobody_knows(likelihood):
    """A division by nothing, or by a rounding error."""
    known = {d: np.full(3, likelihood / 3.0) for d in (0.5, 0.75, 1.0)}
    assert _vertex(known, 0.75) == (0.75, np.inf)
