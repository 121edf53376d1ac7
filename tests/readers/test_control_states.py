"""States of ROS controllers, each kind of message, and bags too long for lists of numbers."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.readers.bags import read_bag

JOINTS = ("a", "b")
POINT = "trajectory_msgs/JointTrajectoryPoint"
MESSAGES = {
    "InterfaceValue": "string[] interface_names\nfloat64[] values",
    "DynamicJointState": "std_msgs/Header header\nstring[] joint_names\n"
    "control_msgs/InterfaceValue[] interface_values",
    "SingleDOFState": "string name\nfloat64 reference\nfloat64 feedback\nfloat64 feedback_dot\n"
    "float64 error\nfloat64 output",
    "MultiDOFStateStamped": "std_msgs/Header header\ncontrol_msgs/SingleDOFState[] dof_states",
}
OLD = (
    f"std_msgs/Header header\nstring[] joint_names\n{POINT} desired\n{POINT} actual\n{POINT} error"
)
NEW = OLD.replace("desired", "reference").replace("actual", "feedback") + f"\n{POINT} output"


def _store(state=OLD):
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in {**MESSAGES, "JointTrajectoryControllerState": state}.items():
        store.register(get_types_from_msg(text, f"control_msgs/msg/{name}"))
    return store


def _motion(samples=200):
    t = np.arange(samples) * 0.01
    return t, np.column_stack([np.sin(t), np.cos(t)])


def _write(folder, store, msgtype, make, samples=200, stamps=None):
    from rosbags.rosbag2 import StoragePlugin, Writer

    header, stamp = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    t, q = _motion(samples)
    with Writer(folder / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        link = writer.add_connection("/states", msgtype, typestore=store)
        for k in range(samples) if stamps is None else stamps:
            ns = round(t[k] * 1e9) + 10**18
            head = header(stamp(ns // 10**9, ns % 10**9), "")
            writer.write(link, ns, store.serialize_cdr(make(store, head, q[k]), msgtype))
    return folder / "bag"


def _dynamic(store, head, q):
    value = store.types["control_msgs/msg/InterfaceValue"]
    state = store.types["control_msgs/msg/DynamicJointState"]
    names = ["position", "velocity", "effort", "temperature"]
    values = [value(names, np.array([x, -x, 10 * x, 30.0])) for x in q]
    return state(head, list(JOINTS), values)


def _point(store, q):
    duration = store.types["builtin_interfaces/msg/Duration"](0, 0)
    return store.types["trajectory_msgs/msg/JointTrajectoryPoint"](q, -q, q * 0, 10 * q, duration)


def _trajectory(store, head, q):
    wrong = _point(store, q + 5)
    state = store.types["control_msgs/msg/JointTrajectoryControllerState"]
    points = [wrong, _point(store, q), wrong]
    fields = len(state.__dataclass_fields__) - 2
    fields -= "__msgtype__" in state.__dataclass_fields__
    return state(head, list(JOINTS), *points, *[wrong] * (fields - 3))


def _several(store, head, q):
    one = store.types["control_msgs/msg/SingleDOFState"]
    state = store.types["control_msgs/msg/MultiDOFStateStamped"]
    return state(head, [one(n, 9.0, x, -x, 0.1, 7.0) for n, x in zip(JOINTS, q, strict=True)])


@pytest.mark.parametrize(
    ("name", "make", "definition", "effort"),
    [
        ("DynamicJointState", _dynamic, OLD, True),
        ("JointTrajectoryControllerState", _trajectory, OLD, True),
        ("JointTrajectoryControllerState", _trajectory, NEW, True),
        ("MultiDOFStateStamped", _several, OLD, False),
    ],
)
def test_what_was_measured_is_taken_and_not_what_was_asked(
    tmp_path, name, make, definition, effort
):
    path = _write(tmp_path, _store(definition), f"control_msgs/msg/{name}", make)
    found = read_bag(path, JOINTS).columns
    t, q = _motion()
    np.testing.assert_allclose(found["time"], t, atol=1e-9)
    for j in (0, 1):
        np.testing.assert_array_equal(found[f"q{j + 1}"], q[:, j])
        np.testing.assert_array_equal(found[f"dq{j + 1}"], -q[:, j])
        if effort:
            np.testing.assert_array_equal(found[f"tau{j + 1}"], 10 * q[:, j])
    assert ("tau1" in found) is effort  # a controller's output is a command


def test_stamps_out_of_order_are_put_in_order(tmp_path):
    order = [1, 0, *range(2, 200)]
    path = _write(tmp_path, _store(), "control_msgs/msg/DynamicJointState", _dynamic, stamps=order)
    found = read_bag(path, JOINTS).columns
    assert (np.diff(found["time"]) > 0).all()
    np.testing.assert_array_equal(found["q1"], _motion()[1][:, 0])


def test_other_messages_are_named(tmp_path):
    def odd(store, head, q):
        return store.types["std_msgs/msg/Float64"](1.0)

    path = _write(tmp_path, _store(), "std_msgs/msg/Float64", odd)
    with pytest.raises(UserError, match=r"no sensor_msgs/msg/JointState; found std_msgs/msg/Fl"):
        read_bag(path, JOINTS)


@pytest.mark.long
def test_an_hour_at_1_khz_would_fit_into_memory(tmp_path):
    """Numbers are kept as numbers: 2 GB are 79 bytes for each of the 25.2 million values."""
    samples = 3000
    path = _write(tmp_path, _store(), "control_msgs/msg/DynamicJointState", _dynamic, samples)
    read_bag(path, JOINTS)  # whatever is imported once
    shares = []
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    found = read_bag(path, JOINTS, shares.append).columns
    kept = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    values = samples * len(JOINTS) * 3
    assert len(found["q1"]) == samples
    assert kept < 30 * values
