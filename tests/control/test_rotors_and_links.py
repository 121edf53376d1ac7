"""A link weighs, a rotor does not: slow torques tell them apart where one response cannot."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.control.gains import BUS_DELAY
from pa10d.control.joint_figures import presumed_figures
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.dynamics.mass import mass_matrices
from pa10d.experiments.felt_bodies import ByWeight, told_by_weight
from pa10d.experiments.joint_response import (
    Response,
    by_weight_alone,
    fitted_response,
    response_of,
)
from pa10d.profile import load_profile

RATE = 125.0
LINES = np.array([2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 15.0])


@pytest.fixture(scope="module")
def robot():
    return robot_from_profile(load_profile("pa10-sim"))


def to_and_fro(robot, bodies, rotor, dry, size=0.3):
    """rad and N·m of all joints that slide against dry friction."""
    t = np.arange(round(12.0 * RATE)) / RATE
    w = 1.2 * np.linspace(1.0, 1.7, robot.n)
    q = 0.4 + size * np.sin(np.outer(t, w))
    dq, ddq = size * w * np.cos(np.outer(t, w)), -size * w**2 * np.sin(np.outer(t, w))
    torque = inverse_dynamics(robot, bodies, q, dq, ddq) + rotor * ddq + dry * np.sign(dq)
    return q, torque, RATE


@pytest.mark.parametrize("heavier", [0.6, 1.7])
def test_what_a_link_weighs_tells_its_inertia_and_what_is_beyond_it_is_rotor(robot, heavier):
    presumed = presumed_figures(robot)
    dry, rotor = 0.01 * robot.effort, 12.0 * presumed.rotor
    seen = to_and_fro(robot, heavier * robot.parameters, rotor, dry)
    pose = seen[0][-1]
    rubbing = presumed.but(coulomb=dry)
    told = told_by_weight(robot, rubbing, [seen], {j: [pose] for j in range(robot.n)})
    links = heavier * np.diagonal(mass_matrices(robot, pose[None])[0])
    for j, one in told.items():
        true = np.array([links[j], rotor[j]])
        off = (one.likeliest - true) @ np.linalg.solve(one.spread, one.likeliest - true)
        assert off < 9.2, f"joint {j + 1}: beyond what one of a hundred is"
    assert told[1].spread[0, 0] < (0.25 * links[1]) ** 2, "it lifts the arm"


def response(inertia, viscous=1.0, gravity=0.0):
    s = 2j * np.pi * LINES
    value = np.exp(-s * BUS_DELAY / RATE) / (inertia * s**2 + viscous * s)
    return Response(LINES, value, np.full(len(LINES), 0.06), 0.3, gravity)


def test_a_rotor_that_is_far_from_usual_is_found_in_one_pose():
    """0.1 to 5 kg·m² it was told to be elsewhere, for all beyond the usual was link."""
    seen = [response(0.3 + 0.6)]
    weight = ByWeight(np.array([0.32, 0.4]), np.diag([0.03, 0.5]) ** 2)
    alone = fitted_response(seen, 0.004, 1.0, RATE)
    fit = fitted_response(seen, 0.004, 1.0, RATE, None, weight)
    assert alone.rotor < 0.02
    assert fit.rotor == pytest.approx(0.6, rel=0.15)
    assert fit.link == pytest.approx(1.0, rel=0.2)


def test_a_joint_that_slid_in_no_stroke_is_as_its_weight_tells():
    weight = ByWeight(np.array([0.32, 0.4]), np.array([[0.02, -0.018], [-0.018, 0.02]]))
    fit = by_weight_alone(weight, 0.3, 1.0)
    assert (fit.rotor, fit.link) == pytest.approx((0.4, 0.32 / 0.3))
    assert by_weight_alone(ByWeight(weight.likeliest, 300.0 * weight.spread), 0.3, 1.0) is None


def test_a_line_that_moves_a_joint_by_less_than_its_encoder_tells_nothing():
    """It shows the servo: a wrist of 12 bits was taken for a tenth of its inertia."""
    t, count = np.arange(125) / RATE, 1.5e-3
    torque = np.cos(2 * np.pi * np.outer(t, LINES)).sum(axis=1)[None]
    angle = -sum(np.cos(2 * np.pi * f * t) / (2 * np.pi * f) ** 2 for f in LINES)[None, :, None]

    def errors(size):
        q = np.round(size * angle / count) * count
        found = response_of(q, torque, RATE, LINES, (0.0, count / np.sqrt(12.0)), 0, np.eye(1))
        return found.error

    assert errors(1.0)[:4].max() < 0.3
    assert errors(0.02)[-3:].min() > 1.0


def test_a_spring_that_its_load_would_wind_by_half_a_turn_is_none():
    rotor, link, stiffness = 0.05, 0.3, 8.0
    s = 2j * np.pi * LINES
    through = link * s**2 * stiffness / (link * s**2 + stiffness)
    value = np.exp(-s * BUS_DELAY / RATE) / (rotor * s**2 + s + through)
    seen = [Response(LINES, value, np.full(len(LINES), 0.06), link, 0.0)]
    weight = ByWeight(np.array([link, rotor]), np.diag([0.02, 0.1]) ** 2)
    assert fitted_response(seen, rotor, 1.0, RATE, None, weight).stiffness < 16.0
    kept = fitted_response(seen, rotor, 1.0, RATE, None, weight, 20.0).stiffness
    assert kept >= 20.0
