"""Base parameters: how many, and what they stand for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trees import ALL

from pa10d.dynamics import base_parameters, regressor, robot_from_profile, robot_from_urdf
from pa10d.dynamics.base import random_motion
from pa10d.profile import load_profile
from pa10d.regression.layout import textbook


def pa10(joints):
    profile = load_profile("pa10-sim")
    limits = type(profile.limits)()
    return robot_from_profile(
        profile.model_copy(update={"joints": profile.joints[:joints], "limits": limits})
    )


@pytest.mark.parametrize(
    ("joints", "inertial", "rotor", "all_"), [(4, 22, 24, 32), (7, 43, 48, 62)]
)
def test_counts_of_the_pa10(joints, inertial, rotor, all_):
    layout = textbook(pa10(joints))
    rotors = sum(t.effect.is_rotor for t in layout.terms)
    assert len(layout.base) == inertial
    assert inertial + rotors == rotor
    assert layout.size == all_


@pytest.mark.parametrize("name", sorted(ALL))
def test_base_torque_is_the_whole_torque(name):
    robot = robot_from_urdf(ALL[name])
    base = base_parameters(robot)
    q, dq, ddq = random_motion(robot, 50, seed=77)
    y = regressor(robot, q, dq, ddq)
    whole = y @ robot.parameters.ravel()
    np.testing.assert_allclose(y[:, :, base.kept] @ base.of(robot.parameters), whole, rtol=1e-8)
    assert np.linalg.matrix_rank(y.reshape(-1, 10 * robot.n), tol=1e-8) == len(base)


@given(st.sampled_from(sorted(ALL)), st.integers(0, 1000))
@settings(max_examples=15, deadline=None)
def test_parameters_with_equal_base_have_equal_torque(name, seed):
    robot = robot_from_urdf(ALL[name])
    base = base_parameters(robot)
    rng = np.random.default_rng(seed)
    one = rng.normal(size=10 * robot.n)
    other = np.zeros_like(one)
    other[base.kept] = base.of(one)
    q, dq, ddq = random_motion(robot, 10, seed=seed)
    y = regressor(robot, q, dq, ddq)
    np.testing.assert_allclose(y @ one, y @ other, atol=1e-8)


def test_matrix_and_sentences_agree_with_relations():
    robot = pa10(4)
    base = base_parameters(robot)
    standard = np.random.default_rng(0).normal(size=(4, 10))
    np.testing.assert_allclose(base.matrix() @ standard.ravel(), base.of(standard))
    assert len(base.sentences()) == 22


def test_redundant_rotor_inertias_lie_in_the_rigid_base():
    layout = textbook(pa10(7))
    fitted = {t.joints[0] for t in layout.terms if t.effect.is_rotor}
    assert fitted == {2, 3, 4, 5, 6}


def seven_joints(right):
    """An arm of the xArm's kind: each axis turned by a right angle to the one before."""
    turns = (0, -1, 1, 1, 1, 1, -1)
    offsets = ("0 0 .27", "0 0 0", "0 -.29 0", ".05 0 0", ".08 -.34 0", "0 0 0", ".08 .1 0")
    parts = ['<robot name="seven"><link name="l0"/>']
    for j, (turn, xyz) in enumerate(zip(turns, offsets, strict=True), 1):
        parts.append(
            f'<joint name="j{j}" type="revolute"><parent link="l{j - 1}"/><child link="l{j}"/>'
            f'<origin xyz="{xyz}" rpy="{turn * right!r} 0 0"/><axis xyz="0 0 1"/>'
            f'<limit lower="-3" upper="3" effort="50" velocity="3"/></joint><link name="l{j}">'
            f'<inertial><mass value="2"/><origin xyz="0.01 0.0{j} -0.03"/><inertia ixx="0.01" '
            'ixy="0.001" ixz="0" iyy="0.008" iyz="0" izz="0.006"/></inertial></link>'
        )
    return "".join([*parts, "</robot>"])


def test_a_right_angle_of_five_digits_makes_no_parameter():
    """xArm's file: a column that shows itself by the 4 millionths of a radian took the place of
    one that can be measured, and the condition number was 1e7."""
    exact, rounded = (seven_joints(right) for right in (np.pi / 2, 1.5708))
    conditions = []
    for urdf in (exact, rounded):
        robot = robot_from_urdf(urdf)
        base = base_parameters(robot)
        assert len(base) == 43
        q, dq, ddq = random_motion(robot, 100, seed=5)
        columns = regressor(robot, q, dq, ddq).reshape(-1, 70)[:, base.kept]
        conditions.append(np.linalg.cond(columns / np.linalg.norm(columns, axis=0)))
    assert conditions[1] == pytest.approx(conditions[0], rel=0.01)
