"""Friction whose peak lies where its joint turns round: reversals have a say in its shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.signal
from small_machines import machine

from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.steps import Search
from pa10d.effects import effect
from pa10d.identify.procedure import identify

FS, VS = 0.35, 0.1  # N·m, rad/s
ASKED = (("load_friction", (0,)), ("load_friction", (1,)), ("torque_gain", (1,)))


def with_bump(run):
    """Stribeck friction in joint 2, on top of what the real joint has."""
    sos = scipy.signal.butter(3, 25.0 / (0.5 * run.rate), output="sos")
    speed = np.gradient(scipy.signal.sosfiltfilt(sos, run.q[:, 1]), run.t)
    tau = run.tau.copy()
    tau[:, 1] += FS * np.exp(-np.abs(speed) / VS) * np.tanh(speed / 0.01)
    return replace(run, tau=tau)


@pytest.mark.long
def test_a_bump_that_would_spoil_reversals_is_named_with_the_shape_that_they_agree_with():
    """Fitted clear of them alone its peak came out higher, which made them worse, and it was
    refused: the real joint's friction of other kinds had drawn the foot to it."""
    robot, runs = machine("double_pendulum", ["train1.csv", "valid1.csv"])
    train, valid = (with_bump(run) for run in runs)
    model = identify([train], robot, name="m0")
    fit, held, _ = two_sides(model, [train], [valid])
    state = SearchState.start(model, fit, held)
    asked = [(effect(kind), at) for kind, at in (*ASKED, ("stribeck", (1,)))]
    search = Search(state, asked, len(state.terms)).run()
    (found,) = [t for t in search.state.terms if t.effect_id == "stribeck"]
    assert found.joints == (1,)
    assert 0.0 < found.coefficients[0] < FS
    without = search.state.copy()
    without.drop(search.state.terms.index(found))
    without.refit()
    assert search.state.moving_rms()[1] < 0.95 * without.moving_rms()[1]
