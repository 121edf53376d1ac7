"""The matrix by which excitation is judged."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.dynamics import inverse_dynamics, regressor, robot_from_urdf
from pa10d.dynamics.base import random_motion
from pa10d.dynamics.observation import (
    change_of_base,
    condition_number,
    model_columns,
    observation_columns,
)
from pa10d.profile import find_profile
from pa10d.trajectory.subarm import sub_arm
from tests.trajectory.sample_arms import pa10, random_tree

URDF = find_profile("pa10-sim").parent / "pa10_7c.urdf"


@pytest.mark.parametrize(("joints", "inertial", "whole"), [(4, 22, 32), (7, 43, 62)])
def test_as_many_columns_as_torque_can_tell_apart(joints, inertial, whole):
    arm = sub_arm(pa10(), np.arange(joints), np.zeros(7))
    q, dq, ddq = random_motion(arm, 400, 5)
    rigid = regressor(arm, q, dq, ddq).reshape(-1, 10 * joints)
    assert np.linalg.matrix_rank(rigid, 1e-9 * np.linalg.norm(rigid)) == inertial
    for columns in (observation_columns(arm), model_columns(arm)):
        assert len(columns) == whole
        matrix = columns.matrix(q, dq, ddq).reshape(-1, whole)
        assert np.linalg.matrix_rank(matrix / np.linalg.norm(matrix, axis=0)) == whole


def test_the_condition_number_is_that_of_the_matrix_written_out():
    arm = sub_arm(pa10(), np.arange(4), np.zeros(7))
    q, dq, ddq = random_motion(arm, 100, 3)
    columns = observation_columns(arm)
    rows = []
    for s in range(100):  # sample by sample, joint by joint
        rigid = regressor(arm, q[s : s + 1], dq[s : s + 1], ddq[s : s + 1])[0]
        for j in range(4):
            row = [rigid[j, k] for k in columns.inertial]
            row += [ddq[s, r] if r == j else 0.0 for r in columns.rotor]
            row += [np.arctan(50 * dq[s, i]) * 2 / np.pi if i == j else 0.0 for i in range(4)]
            row += [dq[s, i] if i == j else 0.0 for i in range(4)]
            rows.append(row)
    values = np.linalg.svd(np.array(rows), compute_uv=False)
    assert condition_number(arm, q, dq, ddq) == pytest.approx(values[0] / values[-1], rel=1e-9)


def test_both_bases_span_the_same_torques():
    arm = sub_arm(pa10(), np.arange(4), np.zeros(7))
    one, other = observation_columns(arm), model_columns(arm)
    motion = random_motion(arm, 50, 9)
    there = one.matrix(*motion) @ change_of_base(one, other)
    assert there == pytest.approx(other.matrix(*motion), abs=1e-8)


def assert_part_is_the_whole_held(robot, joints, pose, rng):
    """The torques of some joints are those of the whole arm with the others standing in a pose."""
    part = rng.normal(size=(3, 9, len(joints)))
    whole = np.zeros((3, 9, robot.n))
    whole[0] = pose
    whole[:, :, joints] = part
    arm = sub_arm(robot, np.array(joints), pose)
    found = inverse_dynamics(arm, arm.parameters, *part)
    assert found == pytest.approx(inverse_dynamics(robot, robot.parameters, *whole)[:, joints])


@pytest.mark.parametrize("joints", [[0, 1, 2, 3], [3], [1, 4, 6], [6, 2]])
def test_a_part_of_the_arm_has_the_torque_of_the_whole(joints):
    robot, rng = pa10(), np.random.default_rng(0)
    pose = rng.uniform(-2, 2, 7)
    assert_part_is_the_whole_held(robot, joints, pose, rng)


def test_joints_held_at_zero_are_those_that_the_urdf_reader_locks():
    names = ["S1", "S2", "S3", "E1"]
    read = robot_from_urdf(URDF, names)
    part = sub_arm(robot_from_urdf(URDF), np.arange(4), np.zeros(7))
    assert part.joint_names == read.joint_names
    assert part.parameters == pytest.approx(read.parameters, abs=1e-12)
    assert part.rotation == pytest.approx(read.rotation)


def test_a_sliding_joint_can_be_held_too():
    robot = random_tree(5, 3)
    assert robot.prismatic.any()
    held = int(np.flatnonzero(robot.prismatic)[0])
    joints = [j for j in range(5) if j != held]
    rng = np.random.default_rng(0)
    assert_part_is_the_whole_held(robot, joints, rng.normal(size=5), rng)
