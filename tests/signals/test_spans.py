"""Where something holds without a break."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pa10d.measurement.spans import spans


@given(st.lists(st.booleans(), max_size=30).map(lambda given: np.array(given, dtype=bool)))
def test_they_cover_what_holds_and_never_touch(flags):
    found = spans(flags)
    again = np.zeros_like(flags)
    for begin, end in found:
        assert begin < end
        again[begin:end] = True
    assert np.array_equal(again, flags)
    assert np.all(found[1:, 0] > found[:-1, 1])
