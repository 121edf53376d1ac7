"""Runs of two loggers: torque that is later in one run than in the other."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import RATE, motion, robot, textbook_torque

from pa10d.identify import identify
from pa10d.measurement.recording import Recording

SAID = "later against position in run"


def recorded(name: str, seed: int, late: float) -> Recording:
    """late: s by which the torque comes after the angle it belongs to."""
    t, q, dq, ddq = motion(seed)
    tau = textbook_torque(q, dq, ddq)
    tau += 0.02 * np.random.default_rng(seed).standard_normal(tau.shape)
    steps = round(late * RATE)
    return Recording(name, t[steps:], q[steps:], tau[: len(t) - steps])


@pytest.mark.by_default("0")
@pytest.mark.parametrize("seed", range(3))
def test_runs_that_are_late_by_different_times_are_named(seed):
    """They were fitted with one shift between the two, and no word was said."""
    runs = [recorded("one", 2 * seed, 0.005), recorded("other", 2 * seed + 1, 0.02)]
    (said,) = [w for w in identify(runs, robot(), name="m").notes.warnings if SAID in w]
    assert "run other than in run one" in said
    assert said.startswith("torque is 1")  # 15 ms, give or take
    assert "± 0" in said


@pytest.mark.by_default("0.0")
@pytest.mark.parametrize("late", [0.0, 0.01])
def test_runs_of_one_logger_are_not(late):
    runs = [recorded("one", 11, late), recorded("other", 12, late)]
    warnings = identify(runs, robot(), name="m").notes.warnings
    assert not any(SAID in w for w in warnings)
