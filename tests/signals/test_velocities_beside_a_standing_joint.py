"""Reported velocities are trusted as they are late, whatever a standing joint beside them says."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.measurement.motion import velocity_source
from pa10d.measurement.recording import Recording

RATE, LATE = 200.0, 0.01


@pytest.mark.parametrize("rest", [0.0, 0.3])
def test_a_joint_that_stands_tells_nothing_of_the_others(rest):
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 20.0, 1.0 / RATE)
    speed = [lambda t, w=w: w * np.cos(w * t) for w in (3.0, 4.1)]
    q = np.column_stack([np.sin(3.0 * t), np.sin(4.1 * t), np.full(len(t), rest)])
    q[:, :2] += rng.normal(0.0, 3e-4, (len(t), 2))
    dq = np.column_stack([*(of(t - LATE) for of in speed), np.zeros(len(t))])
    dq += rng.normal(0.0, 1e-3, dq.shape)
    source = velocity_source(Recording("run", t, q, np.zeros_like(q), dq), 12.0)
    assert source.lag == pytest.approx(LATE, abs=5e-4)
    assert source.reported.tolist() == [True, True, False]


def test_where_no_joint_moves_none_is_late():
    t = np.arange(0.0, 5.0, 1.0 / RATE)
    still = np.zeros((len(t), 2))
    source = velocity_source(Recording("run", t, still, still, still + 1e-3), 12.0)
    assert (source.lag, source.reported.any()) == (0.0, False)
