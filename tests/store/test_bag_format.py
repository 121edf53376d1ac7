"""Runs as independent readers see them: rosbags, the mcap library, and rosbags' CDR."""

from __future__ import annotations

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from store_data import ALL, NAMES, channels, samples

from pa10d.profile import load_profile
from pa10d.store import RunStore
from pa10d.store.ros_messages import DEFINITIONS, float64, float64_array, joint_state, parse

TYPES = get_typestore(Stores.ROS2_HUMBLE)


@pytest.fixture
def stored(tmp_path):
    store = RunStore(tmp_path)
    written = samples(**ALL)
    writer = store.start("all", channels(**ALL), load_profile("pa10-sim"), plan="kind: chirp")
    for k in range(0, 500, 60):
        cut = slice(k, k + 60)
        writer.append(_part(written, cut))
        writer.flush()
    writer.close("stopped", "enough")
    return store, written


def _part(whole, cut):
    from dataclasses import replace

    from pa10d.store import CommandedMotion

    sent = whole.commands
    return replace(
        whole,
        stamps=whole.stamps[cut],
        q=whole.q[cut],
        tau=whole.tau[cut],
        dq=whole.dq[cut],
        commands=CommandedMotion(sent.q[cut], sent.dq[cut], sent.tau[cut]),
        temperature=whole.temperature[cut],
        current=whole.current[cut],
        extra={name: values[cut] for name, values in whole.extra.items()},
    )


def _messages(store):
    found = {}
    with Reader(store.path(store.find("all"))) as reader:
        for connection, stamp, raw in reader.messages():
            message = TYPES.deserialize_cdr(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((stamp, message))
    return found


def test_rosbags_reads_every_message_to_the_bit(stored):
    store, written = stored
    found = _messages(store)
    assert set(found) == {
        "/joint_states", "/joint_commands", "/temperature", "/current",
        "/extra/motor_torque_Nm", "/extra/motor_torque_Nm_", "/extra/c_7", "/extra/phase",
    }  # fmt: skip
    for topic, block in (
        ("/joint_states", (written.q, written.dq, written.tau)),
        ("/joint_commands", (written.commands.q, written.commands.dq, written.commands.tau)),
    ):
        stamps = [stamp for stamp, _ in found[topic]]
        np.testing.assert_array_equal(stamps, written.stamps)
        for field, values in zip(("position", "velocity", "effort"), block, strict=True):
            read = [getattr(message, field) for _, message in found[topic]]
            np.testing.assert_array_equal(read, values)
        for stamp, message in found[topic]:
            assert message.name == list(NAMES)
            header = message.header.stamp
            assert header.sec * 1_000_000_000 + header.nanosec == stamp
    for topic, values in (("/temperature", written.temperature), ("/current", written.current)):
        np.testing.assert_array_equal([m.data for _, m in found[topic]], values)
        assert found[topic][0][1].layout.dim[0].size == 3
    for topic, name in (("/extra/c_7", "7"), ("/extra/motor_torque_Nm", ALL["extra"][0])):
        np.testing.assert_array_equal([m.data for _, m in found[topic]], written.extra[name])


def test_rosbags_finds_a_span_of_time_by_the_indexes(stored):
    store, written = stored
    with Reader(store.path(store.find("all"))) as reader:
        states = [c for c in reader.connections if c.topic == "/joint_states"]
        span = int(written.stamps[100]), int(written.stamps[200])
        found = [stamp for _, stamp, _ in reader.messages(states, *span)]
    assert found == written.stamps[100:200].tolist()


def test_the_mcap_library_finds_indexes_checksums_and_metadata(stored):
    store, written = stored
    path = store.path(store.find("all")) / "run.mcap"
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary.statistics.message_count == 8 * 500
        assert summary.statistics.chunk_count == 9
        assert set(summary.statistics.channel_message_counts.values()) == {500}
        stamps = [m.log_time for _, _, m in reader.iter_messages(["/joint_states"])]
        assert stamps == written.stamps.tolist()
        notes = {m.name: m.metadata for m in reader.iter_metadata()}
    assert notes["pa10d.plan"] == {"plan": "kind: chirp"}
    assert notes["pa10d.end"] == {"status": "stopped", "reason": "enough"}
    assert notes["pa10d.run"]["software"] == "0.1.0"
    profile = load_profile("pa10-sim")
    assert notes["pa10d.profile"]["yaml"] == profile.path.read_text()
    assert notes["pa10d.profile"]["urdf"] == profile.urdf.read_text()


def test_our_reader_gives_back_what_was_written(stored):
    store, written = stored
    run = store.read("all")
    assert (run.joints, run.complete) == (NAMES, True)
    for name in ("stamps", "q", "tau", "dq", "temperature", "current"):
        np.testing.assert_array_equal(getattr(run.samples, name), getattr(written, name))
    for name in ("q", "dq", "tau"):
        read, sent = run.samples.commands, written.commands
        np.testing.assert_array_equal(getattr(read, name), getattr(sent, name))
    assert list(run.samples.extra) == list(ALL["extra"])
    for name, values in written.extra.items():
        np.testing.assert_array_equal(run.samples.extra[name], values)
    recording = store.recording("all")
    assert recording.t[0] == 0.0
    np.testing.assert_allclose(np.diff(recording.t), 0.002, rtol=1e-12)
    np.testing.assert_array_equal(recording.extra["i2"], written.current[:, 1])


TEMPLATES = {
    "with velocity": joint_state(("a", "joint_2", "xyz"), True),
    "without velocity": joint_state(("a", "joint_2", "xyz"), False),
    "one joint": joint_state(("j",), True),
    "names that need padding": joint_state(("ä", "lwr_0_joint", "", "ab"), False),
    "number": float64(),
    "array": float64_array("joint", 6),
    "array of one": float64_array("jo", 1),
}


@pytest.mark.parametrize("case", TEMPLATES)
def test_templates_are_the_bytes_that_rosbags_would_write(case):
    """Numbers put into the template at its fields equal a message serialised by rosbags."""
    template = TEMPLATES[case]
    raw, values = bytearray(template.cdr), {}
    rng = np.random.default_rng(1)
    for name, (code, at) in template.fields.items():
        kind = np.dtype(code)
        value = (
            rng.integers(0, 1000, kind.shape)
            if kind.base.kind in "iu"
            else rng.normal(size=kind.shape)
        )
        values[name] = np.asarray(value, kind.base)
        raw[at : at + kind.itemsize] = values[name].tobytes()
    message = TYPES.deserialize_cdr(bytes(raw), template.type)
    assert bytes(TYPES.serialize_cdr(message, template.type)) == bytes(raw)
    for name, value in values.items():
        holder = message.header.stamp if name in ("sec", "nanosec") else message
        np.testing.assert_array_equal(getattr(holder, name), value)
    again = parse(template.type, bytes(raw))
    assert again.fields == template.fields
    assert again.names == template.names


@pytest.mark.parametrize("name", DEFINITIONS)
def test_definitions_in_the_file_are_those_of_ros(name):
    ours = get_types_from_msg(DEFINITIONS[name], name)
    for type_name, fields in ours.items():
        assert TYPES.fielddefs[type_name] == fields, type_name
