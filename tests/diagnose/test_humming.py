"""What swings in time, and not with the motion, is no effect and no slow noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from two_links import CUTOFF, NAMES, motion, robot, state_of, textbook_torque

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.humming import hums
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording


def hummed(name, seed, size, hertz):
    """A sine in joint 2's torque whose phase nobody knows."""
    rng = np.random.default_rng(seed)
    t, q, dq, ddq = motion(seed)
    tau = textbook_torque(q, dq, ddq) + 0.05 * rng.standard_normal(q.shape)
    tau[:, 1] += size * np.sin(2 * np.pi * hertz * t + rng.uniform(0, 6))
    return Recording(name, t, q, tau)


def sides(size, hertz, other, there=None):
    """Model, runs to fit and runs to judge by."""
    held = size if there is None else there
    runs = [hummed("a", 1, size, hertz), hummed("b", 2, size, hertz), hummed("c", 3, held, other)]
    return identify(runs[:2], robot(), name="m0", cutoff=CUTOFF), runs[:2], runs[2:]


def heard(*lines, **more):
    """Joints in whose torque a hum is heard."""
    model, *both = sides(*lines, **more)
    return [hum.joint for hum in hums(SearchState.start(model, *two_sides(model, *both)[:2]), [1])]


@pytest.mark.long
def test_a_line_in_time_is_told_with_its_frequency():
    found = diagnose(*sides(0.12, 3.1, 3.1))
    assert found.verdict == "unknown"
    (only,) = found.unexplained
    assert (only.joint, only.witness) == (1, "hum")
    assert only.hertz == pytest.approx(3.1, abs=0.01)
    assert only.share > 0.7
    assert "one line in time, at 3.1 Hz on both sides" in found.remaining[1].sentence


@pytest.mark.long
def test_a_line_of_one_side_alone_is_none():
    assert heard(0.12, 3.1, 3.1) == [1]
    assert heard(0.12, 3.1, 4.7) == []


def test_short_runs_have_no_line_with_neighbours():
    """Two seconds and a narrow band: there was a median of nothing, and a warning of numpy's."""
    runs = [hummed(name, seed, 0.12, 3.1) for seed, name in enumerate("abc")]
    model = identify(runs[:2], robot(), name="m0", cutoff=CUTOFF)
    short = [run.part(0, int(2.5 * run.rate), "") for run in runs]
    sides_of = two_sides(model, short[:2], short[2:])[:2]
    assert hums(SearchState.start(model, *sides_of), [0, 1]) == []


def test_a_line_that_is_another_size_on_either_side_does_not_run_on():
    assert heard(0.12, 3.1, 3.1, there=0.12) == [1]
    assert heard(0.04, 3.1, 3.1, there=0.12) == []


def swaying(name, seed, warm):
    """Joints that go to and fro in sines of their own, two minutes: friction that is less on a
    warm day leaves lines at what moves, on both sides and in one phase with none of the runs."""
    rng = np.random.default_rng(seed)
    t = np.arange(12000) / 100.0
    w, a = 2 * np.pi * np.array([0.21, 0.33]), np.array([0.9, 0.7])
    angle = w * t[:, None] + rng.uniform(0, 6, 2)
    q, dq, ddq = a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle)
    tau = textbook_torque(q, dq, ddq) + 0.05 * rng.standard_normal(q.shape)
    return Recording(name, t, q, tau - warm * dq)


@pytest.mark.long
def test_a_line_of_the_motion_itself_is_none():
    """Two days to fit to, one warm and one cold: the friction of neither is the mean's."""
    days = dict(zip(NAMES, (1.0, -1.0, 1.0, -1.0), strict=True))
    runs = {n: swaying(n, k, w * np.array([0.0, 0.6])) for k, (n, w) in enumerate(days.items())}
    assert hums(state_of(runs), [0, 1]) == []


@pytest.mark.long
def test_a_line_beside_the_lines_of_the_motion_is_told():
    runs = {n: swaying(n, k, np.zeros(2)) for k, n in enumerate(NAMES)}
    fan = 0.1 * np.sin(2 * np.pi * 2.71 * runs[NAMES[0]].t)
    runs = {n: replace(r, tau=r.tau + np.column_stack([0 * fan, fan])) for n, r in runs.items()}
    (one,) = hums(state_of(runs), [0, 1])
    assert (one.joint, one.hertz) == (1, pytest.approx(2.71, abs=0.005))
