"""Bags in which joint states come on several topics, or from several senders."""

from __future__ import annotations

import numpy as np
import pytest
from test_formats import JOINTS, URDF

from pa10d.common.errors import UserError
from pa10d.readers import Part, read_recording
from pa10d.services.robots import load_robot

SAMPLES = 300
T = np.arange(SAMPLES) / 200.0
Q = np.stack([0.4 * np.sin(3 * T), 0.3 * np.cos(2 * T)], axis=1)


@pytest.fixture
def robot(tmp_path):
    (tmp_path / "robot.urdf").write_text(URDF)
    return load_robot(tmp_path / "robot.urdf")


def bag(folder, **topics):
    """topics: name -> (names, offset of the positions, times it is sent)."""
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    state, head = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    stamp = store.types["builtin_interfaces/msg/Time"]
    with Writer(folder / "bag", version=9) as writer:
        links = {
            name: writer.add_connection(f"/{name}", state.__msgtype__, typestore=store)
            for name in topics
        }
        for k in range(SAMPLES):
            for name, (joints, offset, times) in topics.items():
                for again in range(times):
                    ns = round(T[k] * 1e9) + 10**18 + again * 1_000_000
                    values = np.resize(Q[k], len(joints)) + offset
                    message = state(
                        head(stamp(ns // 10**9, ns % 10**9), ""), list(joints), values, -values,
                        10 * values,
                    )  # fmt: skip
                    writer.write(links[name], ns, store.serialize_cdr(message, state.__msgtype__))
    return folder / "bag"


def test_what_was_asked_for_is_not_taken_for_measured_however_often_it_was_sent(tmp_path, robot):
    path = bag(tmp_path, joint_states=(JOINTS, 0.0, 1), joint_commands=(JOINTS, 1.0, 3))
    found = read_recording(path, *robot)
    np.testing.assert_array_equal(found.samples.q, Q)
    (said,) = [line for line in found.header_warnings if "topic" in line]
    assert "taken from topic /joint_states; left out: /joint_commands; --topic NAME" in said


@pytest.mark.parametrize("name", ["/other", "other"])
def test_any_topic_can_be_asked_for(tmp_path, robot, name):
    path = bag(tmp_path, joint_states=(JOINTS, 0.0, 2), other=(JOINTS, 1.0, 1))
    found = read_recording(path, *robot, part=Part(topic=name))
    np.testing.assert_array_equal(found.samples.q, Q + 1)
    assert found.header_warnings == []


def test_a_topic_that_is_not_there_is_told_those_that_are(tmp_path, robot):
    path = bag(tmp_path, joint_states=(JOINTS, 0.0, 1))
    with pytest.raises(UserError, match=r"no joint states on topic /arm; found /joint_states"):
        read_recording(path, *robot, part=Part(topic="/arm"))


def test_a_gripper_s_own_topic_does_not_stand_for_the_arm(tmp_path, robot):
    path = bag(tmp_path, gripper=(("finger",), 0.0, 4), joint_states=(JOINTS, 0.0, 1))
    np.testing.assert_array_equal(read_recording(path, *robot).samples.q, Q)


def test_a_refusal_says_which_topic_it_is_about(tmp_path, robot):
    path = bag(tmp_path, left=(("shoulder",), 0.0, 1), right=(("wrist",), 0.0, 1))
    with pytest.raises(UserError, match=r"/left has no joint elbow; .*left out: /right; --topic"):
        read_recording(path, *robot)
