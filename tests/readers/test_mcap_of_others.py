"""MCAP files that no recorder of ROS 2 has finished: the right arrays, as far as they are whole."""

from __future__ import annotations

import json

import numpy as np
import pytest
from test_formats import JOINTS

from pa10d.common.errors import UserError
from pa10d.readers import read_recording

N = 600
T = np.arange(N) / 200.0
Q = np.stack([0.8 * np.sin(3 * T), 0.6 * np.cos(2 * T)], axis=1)
TAU = 5.0 * np.sin(3 * T)[:, None] * [1.0, 0.4] + 0.3 * Q
NS = np.rint(T * 1e9).astype(np.int64) + 10**18
STATE = "sensor_msgs/msg/JointState"


def message(store, k, head):
    types = store.types
    stamp = types["builtin_interfaces/msg/Time"](int(NS[k]) // 10**9, int(NS[k]) % 10**9)
    header = types["std_msgs/msg/Header"](**head, stamp=stamp, frame_id="")
    values = (Q[k, ::-1].copy(), np.zeros(2), TAU[k, ::-1].copy())
    return types[STATE](header, [*reversed(JOINTS)], *values)


def written(folder, profile, encoding="cdr", definition=True, chunk=20_000):
    from mcap.writer import Writer
    from rosbags.typesys import Stores, get_typestore

    old = encoding == "ros1"
    store = get_typestore(Stores.ROS1_NOETIC if old else Stores.ROS2_HUMBLE)
    said = store.generate_msgdef(STATE, ros_version=1 if old else 2)[0]
    path = folder / "run.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=chunk)
        writer.start(profile=profile)
        name, form = ("sensor_msgs/JointState", "ros1msg") if old else (STATE, "ros2msg")
        form = form if definition else ""
        schema = writer.register_schema(name, form, said.encode() if definition else b"")
        channel = writer.register_channel("/joint_states", encoding, schema)
        for k in range(N):
            if encoding == "protobuf":
                data = b"\n\0"
            elif old:
                data = bytes(store.serialize_ros1(message(store, k, {"seq": k}), STATE))
            else:
                data = bytes(store.serialize_cdr(message(store, k, {}), STATE))
            writer.add_message(channel, int(NS[k]), data, int(NS[k]))
        writer.finish()
    return path


@pytest.mark.parametrize(
    ("profile", "encoding", "definition"),
    [("", "cdr", True), ("px4", "cdr", True), ("", "cdr", False), ("ros1", "ros1", True)],
)
def test_another_profile_than_that_of_ros2(tmp_path, robot, profile, encoding, definition):
    found = read_recording(written(tmp_path, profile, encoding, definition), *robot)
    np.testing.assert_array_equal(found.samples.q, Q)
    np.testing.assert_array_equal(found.samples.tau, TAU)
    assert found.header_warnings == []


def cut(raw):
    return raw[: int(0.7 * len(raw))]


def without_end(raw):
    return raw[:-20]


def flipped(raw):
    """And the end is gone: what is behind the damage cannot be trusted."""
    middle = len(raw) // 2
    return raw[:middle] + bytes([raw[middle] ^ 0xFF]) + raw[middle + 1 : -20]


@pytest.mark.parametrize("damage", [cut, without_end, flipped])
@pytest.mark.parametrize("folder", [False, True])
def test_what_is_whole_of_a_file_that_was_cut_off(tmp_path, robot, damage, folder):
    path = written(tmp_path, "ros2")
    path.write_bytes(damage(path.read_bytes()))
    if folder:
        (tmp_path / "bag").mkdir()
        path = path.rename(tmp_path / "bag" / "run_0.mcap").parent
    found = read_recording(path, *robot)
    count = len(found.samples)
    assert count == N if damage is without_end else 100 < count < N
    np.testing.assert_array_equal(found.samples.tau, TAU[:count])
    assert "cut off or damaged, read as far as it is whole" in found.header_warnings[0]


def test_messages_that_are_no_ros_messages(tmp_path, robot):
    path = written(tmp_path, "", "protobuf", definition=False)
    with pytest.raises(UserError, match=r"run.mcap: messages in protobuf; expected cdr or ros1"):
        read_recording(path, *robot)


@pytest.mark.parametrize("fine", ["nanosec", "nsec"])
def test_messages_in_json(tmp_path, robot, fine):
    """As web clients write them; null where a number was none."""
    found = read_recording(in_json(tmp_path, lambda k: said_in_json(k, fine)), *robot)
    np.testing.assert_array_equal(found.samples.q, Q)
    np.testing.assert_array_equal(found.samples.tau, TAU)
    assert found.samples.dq is None
    np.testing.assert_allclose(np.diff(found.timing.grid), 0.005, atol=1e-9)


def test_messages_in_json_of_another_shape(tmp_path, robot):
    with pytest.raises(UserError, match=r"run.mcap: a message in JSON has no field header"):
        read_recording(in_json(tmp_path, lambda k: {"position": Q[k].tolist()}), *robot)


def said_in_json(k, fine):
    stamp = {"sec": int(NS[k]) // 10**9, fine: int(NS[k]) % 10**9}
    return {
        "header": {"stamp": stamp, "frame_id": ""}, "name": [*reversed(JOINTS)],
        "position": Q[k, ::-1].tolist(), "velocity": [None, None],
        "effort": TAU[k, ::-1].tolist(),
    }  # fmt: skip


def in_json(folder, say):
    from mcap.writer import Writer

    path = folder / "run.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("sensor_msgs/JointState", "jsonschema", b"{}")
        channel = writer.register_channel("/joint_states", "json", schema)
        for k in range(N):
            writer.add_message(channel, int(NS[k]), json.dumps(say(k)).encode(), int(NS[k]))
        writer.finish()
    return path
