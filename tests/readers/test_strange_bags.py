"""Bags as robots and their clocks really leave them: the right arrays, or one clear line."""

from __future__ import annotations

import numpy as np
import pytest
from test_formats import JOINTS

from pa10d.common.errors import UserError
from pa10d.readers import read_recording

N = 600
T = np.arange(N) / 200.0
Q = np.stack([0.8 * np.sin(3 * T), 0.6 * np.cos(2 * T)], axis=1)
DQ = np.stack([2.4 * np.cos(3 * T), -1.2 * np.sin(2 * T)], axis=1)
TAU = 5.0 * np.sin(3 * T)[:, None] * [1.0, 0.4] + 0.3 * Q
BEGIN = 10**18
NS = np.rint(T * 1e9).astype(np.int64) + BEGIN
NONE = np.empty(0)
BOTH = (0, 1)


class Bag:
    def __init__(self, folder):
        from rosbags.rosbag2 import Writer
        from rosbags.typesys import Stores, get_typestore

        self.store, self.path = get_typestore(Stores.ROS2_HUMBLE), folder / "bag"
        types = self.store.types
        self.kind, self.head = types["sensor_msgs/msg/JointState"], types["std_msgs/msg/Header"]
        self.stamp = types["builtin_interfaces/msg/Time"]
        self.writer = Writer(self.path, version=9)
        self.writer.open()
        self.link = self.writer.add_connection(
            "/joint_states", self.kind.__msgtype__, typestore=self.store
        )

    def add(self, k, who=BOTH, at=None, came=None, names=JOINTS, **changed):
        """Sample k of the joints ``who``, in this order; changed: other values."""
        at = int(NS[k] if at is None else at)
        who = list(who)
        values = {"position": Q[k, who], "velocity": DQ[k, who], "effort": TAU[k, who]} | changed
        head = self.head(self.stamp(at // 10**9, at % 10**9), "")
        message = self.kind(
            head, [names[j] for j in who], *(np.array(v, dtype=float) for v in values.values())
        )
        data = self.store.serialize_cdr(message, self.kind.__msgtype__)
        self.writer.write(self.link, at if came is None else int(came), data)

    def done(self):
        self.writer.close()
        return self.path


def made(folder, say):
    bag = Bag(folder)
    for k in range(N):
        say(bag, k)
    return bag.done()


def other_order(bag, k):
    bag.add(k, who=BOTH if k % 2 else (1, 0))


def nan_speed(bag, k):
    bag.add(k, velocity=DQ[k] if k > 3 else [np.nan, np.nan])


def no_speed_at_first(bag, k):
    bag.add(k, velocity=DQ[k] if k > 3 else NONE)


def received_late(bag, k):
    bag.add(k, came=NS[k] + int(2e7 * np.random.default_rng(k).uniform()))


def no_header(bag, k):
    bag.add(k, at=0, came=NS[k])


def one_header_missing(bag, k):
    bag.add(k, at=0 if k == 0 else NS[k] - BEGIN + 5 * 10**9, came=NS[k])


def simulated(bag, k):
    bag.add(k, at=NS[k] - BEGIN, came=NS[k] + int(4e6 * np.random.default_rng(k).uniform()))


def header_stands(bag, k):
    bag.add(k, at=BEGIN, came=NS[k])


def whole_seconds(bag, k):
    bag.add(k, at=NS[k] // 10**9 * 10**9, came=NS[k])


def set_back(bag, k):
    bag.add(k, at=NS[k] - (300_000_000 if k >= N // 2 else 0), came=NS[k])


def sent_twice(bag, k):
    for _ in range(1 + (k % 50 == 0)):
        bag.add(k)


def kept_for_listeners(bag, k):
    if k == 0:
        bag.add(0, at=NS[0] - 3600 * 10**9, came=NS[0] - 10)
    bag.add(k)


def gripper(bag, k):
    values = {"position": [*Q[k], 0.01], "velocity": [*DQ[k], 0.0], "effort": [*TAU[k], 0.0]}
    _with_finger(bag, k, values)


def _with_finger(bag, k, values):
    at = int(NS[k])
    head = bag.head(bag.stamp(at // 10**9, at % 10**9), "")
    parts = (np.array(v, dtype=float) for v in values.values())
    message = bag.kind(head, [*JOINTS, "finger"], *parts)
    bag.writer.write(bag.link, at, bag.store.serialize_cdr(message, bag.kind.__msgtype__))


WHOLE = {
    "joints in another order each time": (other_order, ""),
    "a speed that is none at first": (nan_speed, "velocity has 6 values that are none: left out"),
    "no speed at first": (no_speed_at_first, "velocity has 6 values that are none: left out"),
    "received late": (received_late, ""),
    "no header": (no_header, ""),
    "simulated time begins at nothing": (simulated, ""),
    "a header that stands still": (header_stands, "times of reception are taken"),
    "whole seconds": (whole_seconds, "times of reception are taken"),
    "a clock set back": (set_back, "go back by 0.295 s after 1.495 s (a clock was set)"),
    "sent twice": (sent_twice, ""),
    "kept for listeners": (kept_for_listeners, "1 messages of 3600 s before: left out"),
    "a gripper beside": (gripper, ""),
}


@pytest.mark.parametrize("kind", WHOLE)
def test_the_right_arrays(tmp_path, robot, kind):
    say, told = WHOLE[kind]
    found = read_recording(made(tmp_path, say), *robot)
    assert found.timing.rate == pytest.approx(200)
    np.testing.assert_array_equal(found.samples.q, Q)
    np.testing.assert_array_equal(found.samples.tau, TAU)
    assert told in " ".join(found.header_warnings)
    assert bool(told) is bool(found.header_warnings)


def test_a_header_without_a_stamp_costs_its_message_not_the_clock(tmp_path, robot):
    found = read_recording(made(tmp_path, one_header_missing), *robot)
    np.testing.assert_array_equal(found.samples.tau, TAU[1:])
    assert "1 messages of 5 s before: left out" in found.header_warnings[0]


def test_torques_with_every_other_message_are_not_made_up_between(tmp_path, robot):
    path = made(tmp_path, lambda bag, k: bag.add(k, effort=NONE if k % 2 else TAU[k]))
    found = read_recording(path, *robot)
    assert found.timing.rate == pytest.approx(100)
    np.testing.assert_array_equal(found.samples.tau, TAU[::2])
    np.testing.assert_array_equal(found.samples.q, Q[::2])
    (said,) = found.header_warnings
    assert "shoulder.effort comes with 300 of 600 messages: these are taken" in said


@pytest.mark.parametrize("name", ["bag.sqlite3", "recording", "bag.bag"])
def test_a_file_is_what_is_in_it_whatever_it_is_called(tmp_path, robot, name):
    (file,) = made(tmp_path, Bag.add).glob("*.db3")
    np.testing.assert_array_equal(read_recording(file.rename(tmp_path / name), *robot).samples.q, Q)


def test_a_file_that_the_metadata_do_not_know_is_told(tmp_path, robot):
    path = made(tmp_path, Bag.add)
    (file,) = path.glob("*.db3")
    (path / "bag_1.db3").write_bytes(file.read_bytes())
    (said,) = read_recording(path, *robot).header_warnings
    assert "bag_1.db3: not in metadata.yaml, left out" in said


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda text: text.replace("version: 9", "version: 11"), "version 11 not supported"),
        (lambda text: "", "Invalid bag metadata"),
        (lambda text: text.replace(".db3", "_0.db3"), "database files are missing"),
    ],
)
def test_metadata_that_cannot_be_used_are_done_without(tmp_path, robot, spoil, told):
    """Of a later ROS, damaged, or of a file that got another name: the file itself says it all."""
    path = made(tmp_path, Bag.add)
    described = path / "metadata.yaml"
    text = described.read_text()
    described.write_text(spoil(text))
    assert described.read_text() != text
    found = read_recording(path, *robot)
    np.testing.assert_array_equal(found.samples.q, Q)
    (said,) = found.header_warnings
    assert "its metadata.yaml cannot be used" in said
    assert told in said


def two_senders(until=N, pause=(0, 0), every=1):
    def say(bag, k):
        bag.add(k, who=(0,))
        if k < until and not pause[0] < k < pause[1] and k % every == 0:
            bag.add(k, who=(1,), at=NS[k] + 1000)

    return say


def test_a_sender_that_stops_ends_the_recording(tmp_path, robot):
    found = read_recording(made(tmp_path, two_senders(until=300)), *robot)
    assert len(found.samples) == 300
    np.testing.assert_allclose(found.samples.q, Q[:300], atol=3e-5)
    assert "elbow.position was not measured all the time: 300 of 600" in found.header_warnings[0]


def test_a_sender_that_pauses_leaves_a_gap(tmp_path, robot):
    found = read_recording(made(tmp_path, two_senders(pause=(200, 300))), *robot)
    assert len(found.samples) == N
    gap = found.samples.extra["gap"] > 0
    assert gap[205:295].all()
    np.testing.assert_allclose(found.samples.q[~gap], Q[~gap], atol=3e-5)


def test_clocks_of_two_senders_differ(tmp_path, robot):
    def say(bag, k):
        bag.add(k, who=(0,))
        bag.add(k, who=(1,), at=NS[k] - 400_000_000, came=NS[k] + 1000)

    found = read_recording(made(tmp_path, say), *robot)
    np.testing.assert_allclose(found.samples.q, Q[: len(found.samples)], atol=3e-5)
    assert "clocks of the senders differ by 0.4 s: times of reception" in found.header_warnings[0]


def test_a_slow_sender_is_said(tmp_path, robot):
    found = read_recording(made(tmp_path, two_senders(every=10)), *robot)
    assert "elbow.position comes at 20 Hz, others at 200 Hz" in found.header_warnings[0]


def test_torques_that_come_later_begin_the_recording(tmp_path, robot):
    def say(bag, k):
        bag.add(k, effort=TAU[k] if k > 99 else NONE)

    found = read_recording(made(tmp_path, say), *robot)
    np.testing.assert_array_equal(found.samples.q, Q[100:])
    np.testing.assert_array_equal(found.samples.tau, TAU[100:])


def back_on_both_clocks(bag, k):
    at = NS[k] - (300_000_000 if k >= N // 2 else 0)
    bag.add(k, at=at, came=at)


def two_of_the_same(bag, k):
    bag.add(k)
    bag.add(k, at=NS[k] + 2_000_000, position=Q[k] + 0.5)


def begins_anew(bag, k):
    bag.add(k, at=(k % 300 + 1) * 5_000_000, came=NS[k])


def named_twice(bag, k):
    bag.add(k, who=(0, 1, 0))


def torques_too_few(bag, k):
    values = {"position": [*Q[k], 0.01], "velocity": [*DQ[k], 0.0], "effort": TAU[k]}
    _with_finger(bag, k, values)


def no_torque(bag, k):
    bag.add(k, effort=NONE)


def torque_of_nobody(bag, k):
    bag.add(k, effort=[np.nan, np.nan])


def left_and_right(bag, k):
    for side in ("left_", "right_"):
        bag.add(k, at=NS[k] + len(side), names=[f"{side}{joint}" for joint in JOINTS])


def never_together(bag, k):
    bag.add(k, who=(0,) if k < 300 else (1,))


REFUSED = {
    "a clock set back on both sides": (
        back_on_both_clocks, r"between 1.200 and 1.500 s every second sample is of another course",
    ),
    "two senders of the same joints": (two_of_the_same, r"every second sample is of another"),
    "a simulation that began anew": (begins_anew, r"go back by 1.5 s after 1.495 s: they begin an"),
    "a joint named twice": (named_twice, r"a message names shoulder twice"),
    "torques of the arm only": (
        torques_too_few, r"no column tau1.*600 messages have not as many values of effort as names",
    ),
    "no torque": (no_torque, r"no column tau1, tau2"),
    "a torque that is none": (torque_of_nobody, r"no column tau1, tau2"),
    "two arms": (left_and_right, r"several robots, left_, right_: --map 'left_shoulder.position=q"),
    "senders that never speak together": (never_together, r"never speak together"),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_one_clear_line(tmp_path, robot, kind):
    say, told = REFUSED[kind]
    path = made(tmp_path, say)
    with pytest.raises(UserError, match=told) as caught:
        read_recording(path, *robot)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_one_of_two_arms_by_its_line(tmp_path, robot):
    path = made(tmp_path, left_and_right)
    mapping = [
        f"right_{joint}.{kind}={field}{j}"
        for kind, field in (("position", "q"), ("effort", "tau"))
        for j, joint in enumerate(JOINTS, 1)
    ]
    np.testing.assert_allclose(read_recording(path, *robot, mapping).samples.q, Q, atol=1e-6)
