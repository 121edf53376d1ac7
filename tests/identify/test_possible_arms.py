"""Arms that can exist are found to: their feasible fit leaves no more than they do themselves."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace

import numpy as np
import pytest
from drawn_arms import Arm, drawn
from scipy.linalg import qr
from synthetic import fourier

from pa10d.control.live_model import live_model
from pa10d.dynamics import inverse_dynamics, regressor, robot_from_urdf
from pa10d.export.formats import export
from pa10d.identify import identify
from pa10d.identify.feasibility import FeasibleModel, nearest_feasible
from pa10d.measurement.recording import Recording
from pa10d.regression.layout import textbook

NOISE = 0.01  # of a joint's usual torque


@dataclass(frozen=True)
class Problem:
    """What the feasible fit of an arm leaves of each joint, and what the arm itself does, (n,) in
    standard deviations of the noise."""

    feasible: FeasibleModel
    left: np.ndarray
    left_by_truth: np.ndarray


def problem(arm: Arm, seed: int) -> Problem:
    n = arm.robot.n
    layout = textbook(arm.robot)
    _, q, dq, ddq = fourier(n, 20.0, 20.0, seed=seed)
    columns = np.zeros((*q.shape, layout.size))
    columns[..., : len(layout.base)] = regressor(arm.robot, q, dq, ddq, layout.base.kept)
    drive = {"rotor_inertia": ddq, "coulomb": np.tanh(dq / 0.01), "viscous": dq}
    for term, place in zip(layout.terms, layout.places, strict=True):
        (j,) = term.joints
        columns[:, j, place.start] = drive[term.effect_id][:, j]
    clean = arm.torque(q, dq, ddq)
    sigma = NOISE * np.sqrt(np.mean(clean**2, axis=0))
    noise = sigma * np.random.default_rng(seed).normal(size=clean.shape)
    rows = (columns / sigma[:, None]).reshape(-1, layout.size)
    target = ((clean + noise) / sigma).ravel()
    r = qr(np.column_stack([rows, target]), mode="r")[0][: layout.size]

    def rms(beta):
        return sigma * np.sqrt(np.mean(((target - rows @ beta).reshape(-1, n)) ** 2, axis=0))

    found = nearest_feasible(r[:, :-1], r[:, -1], layout, arm.robot, rms)
    return Problem(found, found.rms / sigma, np.sqrt(np.mean((noise / sigma) ** 2, axis=0)))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("joints", [3, 4, 5, 6, 7])
def test_no_more_is_left_than_the_arm_itself_leaves(joints, seed):
    """Torque shows the shoulder's rotor in a sum with the bodies that none of them could make: as
    bodies alone they left up to eleven times the error."""
    one = problem(drawn(joints, seed), seed)
    assert one.feasible.found
    assert np.sum(one.left**2) <= (1 + 1e-3) ** 2 * np.sum(one.left_by_truth**2)
    assert np.all(one.feasible.rotors[:2] > 0)
    assert np.all(one.feasible.rotors[2:] == 0)


def recorded(arm: Arm) -> Recording:
    t, q, dq, ddq = fourier(arm.robot.n, 16.0, 100.0)
    return Recording("drawn", t, q, arm.torque(q, dq, ddq))


@pytest.fixture(scope="module")
def found():
    arm = drawn(4, 5)
    return arm, identify([recorded(arm)], arm.robot, name="drawn", cutoff=8.0)


def test_nothing_is_said_against_an_arm_that_can_exist(found):
    _, model = found
    assert not [one for one in model.notes.warnings if "feasible" in one]


def test_rotors_stand_beside_the_bodies(found):
    """Exports, the loop and the API get the arm that was measured."""
    arm, model = found
    _, q, dq, ddq = (part[::40] for part in fourier(4, 16.0, 100.0, seed=8))
    usual = np.sqrt(np.mean(arm.torque(q, dq, ddq) ** 2, axis=0))
    free = model.torque(q, dq, ddq)
    assert np.all(np.abs(model.torque(q, dq, ddq, parameters="feasible") - free) < 0.01 * usual)
    rotors = np.array(model.notes.feasible.rotors)
    assert rotors[1] == pytest.approx(arm.rotor[1], rel=0.05)
    possible = model.possible()
    assert possible.possible().torque(q, dq, ddq) == pytest.approx(possible.torque(q, dq, ddq))
    assert len(possible.covariance) == len(possible.parameter_names())
    assert not possible.term_values(len(possible.terms) - 1)["Ia"].determined
    live = live_model(model).torque(arm.robot, q, dq, dq, ddq)
    assert live == pytest.approx(possible.torque(q, dq, ddq), abs=1e-9)
    joints = ET.fromstring(export(model, "mjcf").text).iter("joint")
    told = [float(joint.get("armature")) for joint in joints]
    assert told[:2] == pytest.approx(rotors[:2])


def test_a_urdf_holds_the_rotor_of_a_joint_that_nothing_turns(found):
    """As a disc on its link; of the shoulder's it says that it has none."""
    _, model = found
    _, q, dq, ddq = (part[::40] for part in fourier(4, 16.0, 100.0, seed=8))
    for kind in ("urdf", "sdf"):
        said = "\n".join(export(model, kind).not_carried)
        assert "rotor_inertia of joints 2, 3, 4 not in the export" in said
    again = robot_from_urdf(export(model, "urdf").text)
    rubbing = replace(model.possible(), h=0.0 * model.h)
    rubbing = replace(rubbing, terms=tuple(t for t in rubbing.terms if not t.effect.is_rotor))
    friction = rubbing.torque(q, dq, ddq)[:, 0]
    torque = inverse_dynamics(again, again.parameters, q, dq, ddq)[:, 0] + friction
    assert torque == pytest.approx(model.possible().torque(q, dq, ddq)[:, 0], abs=1e-6)
