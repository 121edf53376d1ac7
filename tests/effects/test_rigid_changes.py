"""Payload, tilt and encoder offset against Pinocchio models that really carry, lean or misread."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from effect_motions import (
    arm_context,
    columns,
    pa10,
    pinocchio_model,
    pinocchio_torque,
    rms,
)

from pa10d.dynamics import inverse_dynamics, robot_from_profile, robot_from_urdf
from pa10d.effects import Context, effect
from pa10d.effects.library.base_tilt import rotation
from pa10d.profile import load_profile


def torque(model: pin.Model, context: Context) -> np.ndarray:
    return pinocchio_torque(model, context.q, context.dq, context.ddq)


def coefficients_for(name: str, change: np.ndarray, context: Context, joints=(), rounds: int = 1):
    """Least squares of an exact change on the effect's columns, made anew where it has moved."""
    kind, theta, shape = effect(name), None, {}
    for _ in range(rounds):
        if theta is not None:
            shape = kind.relinearised(theta, shape)
        matrix = kind.columns(context, joints, shape).reshape(change.size, -1)
        theta = np.linalg.lstsq(matrix, change.ravel(), rcond=None)[0]
    left = change.ravel() - matrix @ theta
    return theta, rms(left)


def test_payload_against_a_model_that_carries_it():
    context = arm_context(seed=11)
    mass, com = 2.3, np.array([0.03, -0.02, 0.11])
    about_com = np.diag([0.004, 0.006, 0.005])
    bare, loaded = pinocchio_model(pa10()), pinocchio_model(pa10())
    body = pin.Inertia(mass, com, about_com)
    loaded.inertias[7] = loaded.inertias[7] + body
    change = torque(loaded, context) - torque(bare, context)
    assert columns("payload", context) @ body.toDynamicParameters() == pytest.approx(
        change, abs=1e-9
    )


@pytest.mark.parametrize(("rx", "ry"), [(0.02, 0.0), (0.0, -0.03), (0.05, 0.08)])
def test_tilt_against_a_turned_base(rx, ry):
    """The base turned about its own x, then y axis."""
    context = arm_context(seed=12)
    level, leaning = pinocchio_model(pa10()), pinocchio_model(pa10())
    turn = pin.rpy.rpyToMatrix(rx, 0.0, 0.0) @ pin.rpy.rpyToMatrix(0.0, ry, 0.0)
    leaning.gravity.linear = turn.T @ level.gravity.linear
    change = torque(leaning, context) - torque(level, context)
    theta, left = coefficients_for("base_tilt", change, context, rounds=4)
    assert theta[:2] == pytest.approx([rx, ry], abs=max(2e-5, abs(rx * ry)))
    assert left < 0.03 * rms(change) * (abs(rx * ry) > 0) + 1e-6


def test_tilt_finds_what_an_upright_first_joint_hides():
    """The first link's own imbalance is felt by a leaning arm only; the model cannot know it."""
    context = arm_context(seed=13, size=2.0)
    level, leaning = pinocchio_model(pa10()), pinocchio_model(pa10())
    level.inertias[1] = level.inertias[1] + pin.Inertia(4.0, np.array([0.2, 0.1, 0.0]), np.eye(3))
    leaning.inertias[1] = level.inertias[1]
    leaning.gravity.linear = pin.rpy.rpyToMatrix(0.02, 0.0, 0.0).T @ level.gravity.linear
    change = torque(leaning, context) - torque(level, context)
    theta, left = coefficients_for("base_tilt", change, context, rounds=3)
    assert theta[0] == pytest.approx(0.02, rel=1e-3)
    assert left < 1e-3 * rms(change)
    assert np.hypot(*theta[2:]) == pytest.approx(9.81 * 0.02 * 4.0 * np.hypot(0.2, 0.1), rel=1e-2)


LIFT = """<robot name="lift"><link name="base"/>
<joint name="up" type="prismatic"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="900" velocity="2"/></joint>
<link name="l1"><inertial><mass value="20"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
iyz="0"/></inertial></link>
<joint name="about" type="revolute"><parent link="l1"/><child link="l2"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="90" velocity="2"/></joint>
<link name="l2"><inertial><mass value="6"/><origin xyz="0.3 0.1 0"/><inertia ixx="1" iyy="1" izz="1"
ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="roll" type="revolute"><parent link="l2"/><child link="l3"/><axis xyz="1 0 0"/>
<limit lower="-3" upper="3" effort="90" velocity="2"/><origin xyz="0.5 0 0"/></joint>
<link name="l3"><inertial><mass value="3"/><origin xyz="0 0.05 -0.2"/><inertia ixx="0.2" iyy="0.2"
izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


def test_tilt_finds_what_a_joint_on_a_lift_hides():
    """The joint that turns first on a column knows nothing of its imbalance either: a lean of 0.015
    came out as 0.0046 ± 0.0002 rad, beside a coupled inertia that nobody had put in."""
    robot = robot_from_urdf(LIFT)
    t = np.arange(0.0, 8.0, 0.02)
    q = np.column_stack([0.3 * np.sin(t), 1.4 * np.sin(0.7 * t), np.sin(1.3 * t + 1.0)])
    still, known = np.zeros_like(q), np.array(robot.parameters)
    known[1, 1:3] = 0.0  # what upright motion has never shown
    leaning = robot.with_gravity(rotation(1, 0.015).T @ robot.gravity)
    change = [inverse_dynamics(r, robot.parameters, q, still, still) for r in (leaning, robot)]
    context = Context(robot, t, q, still, still, known, still)
    theta, left = coefficients_for("base_tilt", change[0] - change[1], context, rounds=3)
    assert theta[:2] == pytest.approx([0.0, 0.015], abs=1e-5)
    assert left < 1e-3 * rms(change[0] - change[1])


def test_a_turn_about_the_vertical_is_no_tilt():
    """Of an arm on a wall: rx came out at 3e5 rad, drawn by what rounding made of no torque."""
    context = arm_context(seed=13)
    wall = replace(context, robot=context.robot.with_gravity(np.array([9.81, 0.0, 1e-15])))
    about_x, about_y = (effect("base_tilt").columns(wall, (), {})[..., i] for i in (0, 1))
    assert not about_x.any()
    assert rms(about_y) > 1.0


@pytest.mark.parametrize("offset", [-0.2, 5e-4, 0.06])
@pytest.mark.parametrize("joint", [1, 4])
def test_offset_against_a_misread_angle(joint, offset):
    """Measured = true + offset: the links really stand at measured - offset."""
    context = arm_context(seed=14)
    model = pinocchio_model(pa10())
    true = context.q.copy()
    true[:, joint] -= offset
    change = pinocchio_torque(model, true, context.dq, context.ddq) - torque(model, context)
    theta, left = coefficients_for("encoder_offset", change, context, (joint,), rounds=5)
    assert theta[0] == pytest.approx(offset, rel=1e-3)
    assert left < 1e-3 * rms(change)


def test_offset_begins_as_the_slope():
    context = arm_context(seed=15)
    model, step = pinocchio_model(pa10()), 1e-5
    ahead, back = context.q.copy(), context.q.copy()
    ahead[:, 2] += step
    back[:, 2] -= step
    slope = (
        pinocchio_torque(model, ahead, context.dq, context.ddq)
        - pinocchio_torque(model, back, context.dq, context.ddq)
    ) / (2 * step)
    assert columns("encoder_offset", context, 2)[..., 0] == pytest.approx(-slope, abs=1e-5)


def test_what_a_joint_moves_is_pinocchios_mass_matrix():
    context = arm_context(seed=16, seconds=0.2)
    model = pinocchio_model(pa10())
    data = model.createData()
    exact = np.array([np.diag(pin.crba(model, data, q)) for q in context.q])
    for j in range(7):
        assert context.inertia_seen(j) == pytest.approx(exact[:, j])
        assert exact[:, j].min() / 20 < context.typical_inertia[j] < 20 * exact[:, j].max()


@pytest.mark.parametrize(("profile", "never"), [("pa10-sim", set()), ("cobra600", {"cz"})])
def test_what_of_a_payload_no_motion_of_an_arm_shows(profile, never):
    """All axes of a SCARA are vertical: how high its load is changes nothing."""
    robot = robot_from_profile(load_profile(profile))
    assert effect("payload").never_shown(robot, ()) == never
    assert not effect("spring").never_shown(robot, (0,))


def test_a_wave_over_the_first_angle_beside_no_tilt_is_none():
    """A hose at an upright first joint was as good as "a tilted base" of 0.0003 ± 0.0005 rad, which
    would have had to carry a ton off-centre."""
    tilt, robot = effect("base_tilt"), pa10()
    sure = np.diag([5e-4, 5e-4, 0.5, 0.5]) ** 2
    assert not tilt.could_be(robot, np.array([3e-4, 0.0, 1.0, 10.0]), sure)
    assert tilt.could_be(robot, np.array([0.03, 0.0, 1.0, 10.0]), sure)
    assert tilt.could_be(robot, np.array([3e-4, 0.0, 0.1, 1.0]), sure)
    assert tilt.could_be(robot, np.array([3e-4, 0.0, 1.0, 10.0]), sure * 100.0)
    bare = replace(robot, parameters=np.zeros_like(robot.parameters))
    assert tilt.could_be(bare, np.array([3e-4, 0.0, 1.0, 10.0]), sure)
