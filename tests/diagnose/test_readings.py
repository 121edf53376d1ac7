"""Torque that reads wrong by itself, by time or by another joint's is told so, and by no effect."""

from __future__ import annotations

import numpy as np
import pytest
from test_remaining import judged
from two_links import CUTOFF, motion, robot, textbook_torque

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.diagnose.unknown.remaining import remaining
from pa10d.diagnose.unknown.structure import find_readings
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording

NOISE = 0.03


def dead_band(t, tau):
    """Nothing within 1.2 N·m, and as much too little beyond."""
    return np.column_stack([np.sign(tau[:, 0]) * np.maximum(np.abs(tau[:, 0]) - 1.2, 0), tau[:, 1]])


def warming(t, tau):
    """An eighth less once it is warm."""
    return tau * np.column_stack([1.0 - 0.125 * (1.0 - np.exp(-t / 10.0)), np.ones_like(t)])


def cross_talk(t, tau):
    """A step of joint 1's sign in joint 2's channel."""
    return tau + np.column_stack([np.zeros_like(t), 0.6 * np.tanh(tau[:, 0] / 2.0)])


def read(name, seed, by):
    t, q, dq, ddq = motion(seed)
    noise = NOISE * np.random.default_rng(seed).standard_normal(q.shape)
    return Recording(name, t, q, by(t, textbook_torque(q, dq, ddq)) + noise)


READ = pytest.mark.parametrize(
    ("by", "joint", "variables", "hint"),
    [
        (dead_band, 0, ("tau1",), "a dead band"),
        (warming, 0, ("time", "tau1"), "as it warms"),
        (cross_talk, 1, ("tau1",), "takes on another's torque"),
    ],
)


def sides(by):
    """The model of two runs, these, and the one to judge by."""
    runs = [read(name, seed, by) for seed, name in enumerate(("a", "b", "judge"))]
    return identify(runs[:2], robot(), name="m0", cutoff=CUTOFF), runs[:2], runs[2:]


@pytest.mark.by_default("dead_band")
@READ
def test_what_a_reading_depends_on_is_found_and_told(by, joint, variables, hint):
    model, fit, judge = sides(by)
    train, held, _ = two_sides(model, fit, judge)
    state = SearchState.start(model, train, held)
    found = {one.joint: one for one in find_readings(state, range(2))}[joint]
    assert found.variables == variables
    assert found.share > 0.7
    told = Unnamed(joint, found.share, found.rms, found.p_value, "reading", found.variables)
    lines = remaining(judged(5.0, 5.0), [None] * 2, [told], ["N·m"] * 2)
    assert hint in lines[joint].sentence


@pytest.mark.long  # a whole search, which first tries everything else
@READ
def test_a_reading_is_told_as_such_and_as_no_effect(by, joint, variables, hint):
    found = diagnose(*sides(by))
    assert not [f.term.label for f in found.findings]
    told = {one.joint: one for one in found.unexplained}
    assert told[joint].variables == variables
    assert told[joint].share > 0.7
    assert hint in found.remaining[joint].sentence
    mapped = [one.joint for one in found.mapped]
    assert joint not in mapped, "no map of the motion is offered for it"
