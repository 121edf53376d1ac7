"""What pushes back over most of a joint's way is a contact yet."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import recordings, state_of

from pa10d.diagnose.search.candidates import scan, sharpened
from pa10d.effects import effect


def pushed(at: float):
    """8 N·m/rad on joint 2, beyond one angle."""
    return lambda t, q, dq, ddq: np.column_stack([0.0 * t, 8.0 * np.maximum(0.0, q[:, 1] - at)])


@pytest.mark.parametrize("free", [0.25, 0.4])
def test_a_contact_over_most_of_the_way_is_found_where_it_begins(free):
    """Searches began with 40 % of the way at most: a cable that is slack for a little way ended as
    an offset and three ripples without a number."""
    q = np.concatenate([run.q[:, 1] for run in recordings(7).values()])
    at, span = float(q.min() + free * np.ptp(q)), float(np.ptp(q))
    state = state_of(recordings(7, pushed(at), 0.02))
    found = sharpened(state, scan(state, [(effect("contact"), (1,))]))[0]
    assert found.shape["side"] == 1.0
    assert found.shape["qs"] == pytest.approx(at, abs=0.01 * span)
    assert found.partial.theta[0] == pytest.approx(8.0, rel=0.05)
