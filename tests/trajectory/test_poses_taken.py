"""A pose that is not allowed is said with what is wrong with it, and that alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.dynamics import robot_from_profile
from pa10d.profile import load_profile
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.limits import TORQUE_SHARE
from pa10d.trajectory.poses import Surroundings

STRETCHED = np.array([0.0, 1.2, 0.0, 0.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def around():
    return Surroundings.of(robot_from_profile(load_profile("pa10-sim")))


def refused(around, pose):
    with pytest.raises(UserError) as error:
        around.free_range(pose, 0)
    return str(error.value)


def test_a_joint_that_is_too_weak_for_its_load_is_named(around):
    weak = around.limits.torque.copy()
    weak[1] = 1.1 * abs(around.load(STRETCHED, 1))
    said = refused(replace(around, limits=replace(around.limits, torque=weak)), STRETCHED)
    assert "gravity takes 91% of what joint 2 may give by the URDF's masses" in said
    assert "planned with are 80% at most" in said
    assert "nearer" not in said


def test_a_joint_beyond_its_limit_is_named(around):
    pose = np.zeros(7)
    pose[3] = around.limits.upper[3] + 0.01
    assert "is not free: joint 4 is beyond its limit; " in refused(around, pose)


@pytest.mark.parametrize(("share", "tried"), [(0.95, True), (2.9, True), (3.1, False)])
def test_a_first_motion_tries_what_the_motors_may_hold(around, share, tried):
    """A URDF may weigh a joint three times too heavy; nobody has weighed it before."""
    pose = [0.0, 0.0, 0.0, 0.0, 0.0, 1.2, 0.0]
    weak = around.limits.torque.copy()
    weak[5] = TORQUE_SHARE / share * abs(around.load(np.array(pose), 5))
    arm = replace(around, limits=replace(around.limits, torque=weak))
    asked = {"part": "friction", "joints": [6], "pose": pose}
    kind = read_request({"kind": "first_motion", "parameters": asked})
    if tried:
        assert kind.build(arm).kind == "first_motion"
        return
    with pytest.raises(UserError, match="what joint 6 may give by the URDF's masses"):
        kind.build(arm)


def test_where_no_pose_is_light_enough_the_joint_is_named(around):
    weak = around.limits.torque * [1.0, 1e-3, 1.0, 1.0, 1.0, 1.0, 1.0]
    arm = replace(around, limits=replace(around.limits, torque=weak))
    with pytest.raises(UserError, match=r"of the last: gravity takes .* of what joint 2"):
        arm.random_pose(np.random.default_rng(1), tries=3)
