"""Data without noise: the fit must be as good as arithmetic allows."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from synthetic import Truth, estimates, fourier, pa10_truth, recording

from pa10d.dynamics import robot_from_urdf
from pa10d.identify import identify, summary
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import prepare

sys.path.append(str(Path(__file__).parents[1] / "dynamics"))
from trees import ALL


def rnea(robot, q, dq, ddq):
    model, order = robot.pinocchio()
    data = model.createData()
    rows = [pin.rnea(model, data, *(x[s][order] for x in (q, dq, ddq))) for s in range(len(q))]
    torque = np.empty_like(q)
    torque[:, order] = np.array(rows)
    return torque


def relative_error(model, recording) -> np.ndarray:
    equation = prepare(recording, model.robot, model.cutoff, model.shift)
    error = equation.tau - equation.lowpass(model.predict(equation.context))
    inside = equation.inside
    return np.sqrt(np.mean(error[inside] ** 2, 0) / np.mean(equation.tau[inside] ** 2, 0))


@pytest.mark.parametrize(("joints", "rate"), [(4, 200.0), (7, 500.0)])
def test_rnea_torque_is_reproduced_on_a_motion_not_seen(joints, rate):
    robot = pa10_truth(joints).robot
    t, *seen = fourier(joints, 12.0, rate)
    model = identify(
        [Recording("seen", t, seen[0], rnea(robot, *seen))], robot, name="m", cutoff=10.0
    )
    t, *other = fourier(joints, 12.0, rate, seed=8)
    unseen = Recording("unseen", t, other[0], rnea(robot, *other))
    assert np.all(relative_error(model, unseen) < 1e-8)


@pytest.mark.by_default("branched", "prismatic")
@pytest.mark.parametrize("name", sorted(ALL))
def test_any_tree_under_any_mounting(name):
    robot = robot_from_urdf(ALL[name], gravity=np.array([2.0, -5.0, -8.0]))
    none = np.zeros(robot.n)
    truth = Truth(robot, none, none, none)
    model = identify(
        [recording(truth, fourier(robot.n, 12.0, 250.0))], robot, name="m", cutoff=10.0
    )
    assert np.all(relative_error(model, recording(truth, fourier(robot.n, 12.0, 250.0, 8))) < 1e-8)
    np.testing.assert_allclose(estimates(model), truth.values(model), atol=1e-5)


def test_parameters_friction_and_its_sharpness_come_out_right():
    truth = pa10_truth(4, v0=0.02)
    model = identify(
        [recording(truth, fourier(4, 16.0, 500.0))], truth.robot, name="m", cutoff=15.0
    )
    found = [t.shape["v0"] for t in model.terms if t.effect_id == "coulomb"]
    np.testing.assert_allclose(found, 0.02, rtol=0.02)
    sizes = np.maximum(np.abs(truth.values(model)), 0.05)
    assert np.max(np.abs(estimates(model) - truth.values(model)) / sizes) < 0.02
    assert model.feasible


def test_several_runs_are_fitted_together():
    truth = pa10_truth(2)
    runs = [recording(truth, fourier(2, 8.0, 200.0, seed), name=f"r{seed}") for seed in (1, 2)]
    model = identify(runs, truth.robot, name="both", cutoff=10.0)
    assert model.runs == ("r1", "r2")
    np.testing.assert_allclose(estimates(model), truth.values(model), atol=0.02)


@pytest.mark.long
def test_pieces_do_not_change_the_answer(monkeypatch):
    """What is counted in overlapping pieces is what is counted at once."""
    truth = pa10_truth(3)
    noise = np.random.default_rng(0).normal(size=(6000, 3))
    run = recording(truth, fourier(3, 30.0, 200.0), noise)
    whole = identify([run], truth.robot, name="m", cutoff=10.0)
    monkeypatch.setattr("pa10d.identify.cuts.PIECE", 900)
    monkeypatch.setattr("pa10d.identify.blocks.REMEMBERED", 0)
    monkeypatch.setattr("pa10d.identify.blocks.ENOUGH", 100)
    pieces = identify([run], truth.robot, name="m", cutoff=10.0)
    assert np.max(np.abs(estimates(pieces) - estimates(whole)) / whole.std_errors) < 0.05
    assert pieces.notes.condition_number == pytest.approx(whole.notes.condition_number, rel=1e-3)


@pytest.mark.long
def test_summary_of_the_pa10():
    truth = pa10_truth(7)
    noise = 0.1 * np.random.default_rng(1).normal(size=(4000, 7))
    model = identify([recording(truth, fourier(7, 16.0, 250.0), noise)], truth.robot, name="arm")
    found = summary(model)
    assert found.base_parameters == 62
    assert found.inertial_base_parameters == 43
    assert found.feasible is True
    assert found.cutoff_hz == model.cutoff
    assert len(found.rms) == 7
    assert found.condition_number > 1
