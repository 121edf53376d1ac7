"""ROS 2 bags, folders or single files: joint states by name onto the robot's joints."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.readers.table import Table
from pa10d.store.channels import Array

STATES = "sensor_msgs/msg/JointState"
CONTROLLERS = (
    "control_msgs/msg/JointTrajectoryControllerState",
    "control_msgs/msg/JointControllerState",
)
FIELDS = {"position": "q", "velocity": "dq", "effort": "tau"}
Rows = dict[str, list[tuple[float, float]]]


def read_bag(path: Path, joints: Sequence[str]) -> Table:
    """The topic with the most samples of the robot's joints; each joint by its name.

    Where a message has only some of the joints (one topic, several senders) the others are taken
    at its stamps by straight lines.
    """
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    seen: dict[str, Rows] = {}
    try:
        store = get_typestore(Stores.ROS2_HUMBLE)
        with AnyReader([_opened(path)], default_typestore=store) as reader:
            wanted = [c for c in reader.connections if c.msgtype in (STATES, *CONTROLLERS)]
            if not wanted:
                there = ", ".join(sorted({c.msgtype for c in reader.connections})) or "nothing"
                raise UserError(f"{path}: no {STATES}; found {there}")
            for connection, stamp, raw in reader.messages(connections=wanted):
                message = reader.deserialize(raw, connection.msgtype)
                rows = seen.setdefault(connection.topic, defaultdict(list))
                _take(message, connection.msgtype == STATES, stamp, rows)
    except UserError:
        raise
    except Exception as error:  # whatever a damaged bag makes of its reader
        said = (str(error).strip() or type(error).__name__).splitlines()[0][:160]
        raise UserError(f"{path}: cannot be read ({said}); expected a ROS 2 bag") from error
    topic = max(seen, key=lambda name: _worth(seen[name], joints), default=None)
    if topic is None:
        raise UserError(f"{path}: no message on its joint states; expected a recorded motion")
    table = Table(_columns(path, topic, seen[topic], joints))
    if len(seen) > 1:
        others = ", ".join(sorted(set(seen) - {topic}))
        table.remarks.append(f"taken from topic {topic}; left out: {others}")
    return table


def _opened(path: Path) -> Path:
    """rosbags opens single files of both kinds, and folders by their metadata."""
    if path.is_dir() and not (path / "metadata.yaml").is_file():
        files = sorted([*path.glob("*.mcap"), *path.glob("*.db3")])
        if len(files) != 1:
            raise UserError(
                f"{path}: no metadata.yaml and {len(files)} bag files; expected a bag's folder"
            )
        return files[0]
    return path


def _take(message: Any, states: bool, stamp: int, rows: Rows) -> None:
    header = message.header.stamp
    t = header.sec + 1e-9 * header.nanosec
    if t <= 0:
        t = stamp * 1e-9
    if states:
        names, found = message.name, {k: getattr(message, k) for k in FIELDS}
    else:
        point = getattr(message, "feedback", None) or message.actual
        names = message.joint_names
        found = {
            "position": point.positions, "velocity": point.velocities, "effort": point.effort,
        }  # fmt: skip
    for kind, values in found.items():
        if len(values) == len(names):
            for name, value in zip(names, values, strict=True):
                rows[f"{name}.{kind}"].append((t, float(value)))


def _worth(rows: Rows, joints: Sequence[str]) -> tuple[int, int]:
    mine = [len(rows.get(f"{joint}.effort", ())) for joint in joints]
    return sum(count > 0 for count in mine), sum(map(len, rows.values()))


def _columns(path: Path, topic: str, rows: Rows, joints: Sequence[str]) -> dict[str, Array]:
    series = {name: np.array(found) for name, found in rows.items()}
    lead = max(series.values(), key=len)
    order = np.argsort(lead[:, 0], kind="stable")
    t = lead[order, 0]
    have = {name.rpartition(".")[0] for name in series}
    known = [joint for joint in joints if joint in have]
    if known and len(known) < len(joints):
        missing = ", ".join(joint for joint in joints if joint not in have)
        raise UserError(
            f"{path}: {topic} has no joint {missing}; found {', '.join(sorted(have))}; expected "
            "the names of the robot's URDF, or --map 'NAME.position=q1' …"
        )
    out: dict[str, Array] = {"time": t - np.floor(t[0])}
    for name, found in series.items():
        joint, _, kind = name.rpartition(".")
        column = f"{FIELDS[kind]}{joints.index(joint) + 1}" if joint in known else name
        if np.isnan(found[:, 1]).all():
            continue
        same = len(found) == len(t) and np.array_equal(found[:, 0], lead[:, 0])
        at = np.argsort(found[:, 0], kind="stable")
        out[column] = found[order, 1] if same else np.interp(t, found[at, 0], found[at, 1])
    return out
