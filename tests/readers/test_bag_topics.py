"""Bags in which joint states come on several topics, or from several senders."""

from __future__ import annotations

import numpy as np
import pytest
from test_formats import JOINTS

from pa10d.common.errors import UserError
from pa10d.readers import Part, read_recording, read_table

SAMPLES = 300
T = np.arange(SAMPLES) / 200.0
Q = np.stack([0.4 * np.sin(3 * T), 0.3 * np.cos(2 * T)], axis=1)


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
    assert "taken from topic /joint_states; left out: /joint_commands" in said
    assert found.another == "--topic NAME takes another"


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


def test_an_arm_on_two_topics_is_joined_by_name(tmp_path, robot):
    path = bag(tmp_path, left=(JOINTS[:1], 0.0, 1), right=(JOINTS[1:], 0.5, 1))
    found = read_recording(path, *robot)
    np.testing.assert_array_equal(found.samples.q, np.stack([Q[:, 0], Q[:, 0] + 0.5], axis=1))
    [said] = found.header_warnings
    assert f"joined: {JOINTS[0]} from /left; {JOINTS[1]} from /right" in said
    again = read_recording(path, *robot, part=Part(topic="left,right"))
    np.testing.assert_array_equal(again.samples.q, found.samples.q)


def test_two_clocks_are_made_one_and_it_is_said(tmp_path, robot):
    """The slower one's, where the other speaks at each of them as well: nothing is made up."""
    path = bag(tmp_path, left=(JOINTS[:1], 0.0, 1), right=(JOINTS[1:], 0.0, 2))
    found = read_recording(path, *robot)
    assert f"{JOINTS[0]}.position comes with 300 of 600 messages" in found.header_warnings[0]
    np.testing.assert_array_equal(found.samples.q[:, 0], Q[:, 0])


def test_what_two_topics_both_say_is_not_joined(tmp_path, robot):
    path = bag(tmp_path, arm=(JOINTS, 0.0, 1), other=(JOINTS[1:], 0.5, 1))
    np.testing.assert_array_equal(read_recording(path, *robot).samples.q, Q)
    with pytest.raises(UserError, match=f"joint {JOINTS[1]} is on /arm and on /other"):
        read_recording(path, *robot, part=Part(topic="arm,other"))


def test_what_a_bag_has_to_choose_from_is_known(tmp_path, robot):
    path = bag(tmp_path, left=(JOINTS[:1], 0.0, 1), right=(JOINTS[1:], 0.5, 1))
    parts = read_table(path, *robot).parts
    assert parts.taken == "/left,/right"
    assert list(parts.options) == ["/left,/right", "/left", "/right"]
    assert parts.options["/left"] == "/left · 300 messages"
