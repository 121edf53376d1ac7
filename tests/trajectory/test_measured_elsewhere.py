"""Each joint is measured where its inertia is another one, too: what is rotor and what link one
pose does not tell."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.dynamics import robot_from_profile
from pa10d.profile import load_profile
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.kinds.first_motion import shaken_joint, shared_out
from pa10d.trajectory.poses import Surroundings


def measured_elsewhere(name: str) -> list[int]:
    """The joints (from 1) of the last part, in their order."""
    around = Surroundings.of(robot_from_profile(load_profile(name)))
    asked = read_request({"kind": "first_motion", "parameters": {"part": "poses"}})
    found = [shaken_joint(span.label) for span in asked.build(around).spans]
    return list(dict.fromkeys(j + 1 for j in found if j is not None))


def test_joints_that_the_heaviest_pose_does_not_tell_get_one_of_their_own():
    assert measured_elsewhere("pa10-sim") == [1, 3], "where that tells all, nothing else is done"
    assert measured_elsewhere("panda") == [1, 2, 7, 3], "joint 1 alone in the heaviest pose"


def test_as_few_poses_as_will_do():
    varies = np.array([[1, 0, 0, 0, 0], [1, 1, 0, 0, 0], [1, 1, 1, 0, 0], [0, 0, 0, 1, 0]], bool)
    assert shared_out(varies) == [[0], [], [1, 2], [3]]
    assert shared_out(np.zeros((2, 3), bool)) == [[], []]


@pytest.mark.parametrize("part", ["friction", "sliding", "response"])
def test_a_joint_that_has_nowhere_to_go_is_named(monkeypatch, part):
    """No stroke was ever short enough, and the plan was never there."""
    around = Surroundings.of(robot_from_profile(load_profile("pa10-sim")))
    free = Surroundings.free_range

    def hemmed_in(self, pose, joint):
        return (pose[joint], pose[joint]) if joint == 2 else free(self, pose, joint)

    monkeypatch.setattr(Surroundings, "free_range", hemmed_in)
    asked = {"kind": "first_motion", "parameters": {"part": part}}
    with pytest.raises(UserError, match=r"^joint 3 has a way of 0 rad about the pose .*joints"):
        read_request(asked).build(around)
    others = [joint for joint in range(1, around.robot.n + 1) if joint != 3]
    asked["parameters"]["joints"] = others
    assert read_request(asked).build(around).duration > 0.0
