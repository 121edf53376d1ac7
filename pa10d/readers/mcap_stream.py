"""MCAP from its first record to its last whole one: files that were cut off, and those whose
profile is not ROS 2's, which rosbags leaves alone."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.readers.signatures import MCAP

END = b"\x89MCAP0\r\n"
PROFILE = "ros2"
FORMS = {"cdr": "deserialize_cdr", "ros1": "deserialize_ros1"}
"""How messages are encoded -> how rosbags reads them."""
JSON = "json"
ABSENT = {"name", "joint_names", "position", "velocity", "effort", "positions", "velocities"}
"""Lists that a message in JSON may leave away."""
FINE = ("nanosec", "nsec", "nsecs")


class JsonMessage:
    """A message of ROS that somebody wrote in JSON: its fields are attributes, as rosbags has
    them; stamps have the names of ROS 2; null is nan."""

    def __init__(self, fields: JsonObject) -> None:
        if "secs" in fields:
            fields["sec"] = fields["secs"]
        for name in FINE:
            if name in fields:
                fields["nanosec"] = fields[name]
        for name, value in fields.items():
            bare = isinstance(value, list) and None in value
            setattr(self, name, [math.nan if v is None else v for v in value] if bare else value)

    def __getattr__(self, name: str) -> Any:
        if name in ABSENT:
            return []
        raise UserError(f"a message in JSON has no field {name}; expected those of ROS")


@dataclass(frozen=True)
class McapChannel:
    """As rosbags' connections are. key: file and channel."""

    topic: str
    msgtype: str
    encoding: str
    key: tuple[int, int]
    msgcount: int


def is_odd_mcap(path: Path) -> bool:
    """Whether a file is MCAP, but without an end, or not of the profile that rosbags reads."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(64)
        if not head.startswith(MCAP):
            return False
        size = int.from_bytes(head[17:21], "little")
        profile = head[21 : 21 + size].decode("utf-8", "replace")
        file.seek(-min(path.stat().st_size, len(END)), 2)
        return profile != PROFILE or file.read() != END


class McapStream:
    """The part of rosbags' AnyReader that bags are read by. cut: files that end within a record."""

    def __init__(self, paths: Sequence[Path]) -> None:
        self._paths = paths
        self.cut: list[Path] = []
        self.connections: list[McapChannel] = []
        self._forms: dict[str, str] = {}
        self._types: Any = None

    def __enter__(self) -> McapStream:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore

        schemas: dict[tuple[int, int], Any] = {}
        channels: dict[tuple[int, int], Any] = {}
        counts: dict[tuple[int, int], int] = {}
        for number, record in self._records():
            kind = type(record).__name__
            if kind == "Schema":
                schemas[number, record.id] = record
            elif kind == "Channel":
                channels[number, record.id] = record
            elif kind == "Message":
                key = number, record.channel_id
                counts[key] = counts.get(key, 0) + 1
        definitions: dict[str, object] = {}
        for key, channel in channels.items():
            schema = schemas.get((key[0], channel.schema_id))
            name = _full(schema.name) if schema else ""
            form = channel.message_encoding
            self.connections.append(McapChannel(channel.topic, name, form, key, counts.get(key, 0)))
            if schema and schema.data and form in FORMS and schema.encoding.endswith("msg"):
                definitions |= get_types_from_msg(schema.data.decode(), name)
        store = Stores.EMPTY if definitions else Stores.ROS2_HUMBLE
        self._types = get_typestore(store)
        self._types.register(definitions)
        known = {*FORMS, JSON}
        strange = sorted({c.encoding for c in self.connections} - known)
        self.connections = [c for c in self.connections if c.encoding in known]
        if strange and not self.connections:
            raise UserError(
                f"messages in {', '.join(strange)}; expected cdr or ros1, as ROS has it, or json"
            )
        self._forms = {c.msgtype: c.encoding for c in self.connections}
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """Nothing is held open."""

    def messages(
        self, connections: Collection[McapChannel]
    ) -> Iterator[tuple[McapChannel, int, bytes]]:
        """Channel, time of reception in ns, bytes."""
        wanted = {one.key: one for one in connections}
        for number, record in self._records():
            if type(record).__name__ == "Message":
                channel = wanted.get((number, record.channel_id))
                if channel is not None:
                    yield channel, record.log_time, record.data

    def deserialize(self, raw: bytes, msgtype: str) -> Any:
        """The message."""
        form = self._forms[msgtype]
        if form == JSON:
            return json.loads(raw, object_hook=JsonMessage)
        return getattr(self._types, FORMS[form])(raw, msgtype)

    def _records(self) -> Iterator[tuple[int, Any]]:
        from mcap.stream_reader import StreamReader

        for number, path in enumerate(self._paths):
            with path.open("rb") as file:
                try:
                    for record in StreamReader(file, validate_crcs=True).records:
                        yield number, record
                except Exception:  # whatever a torn or damaged chunk makes of its reader
                    if path not in self.cut:
                        self.cut.append(path)


def _full(name: str) -> str:
    """sensor_msgs/JointState, as ROS 1 calls it -> sensor_msgs/msg/JointState; names that are none
    of ROS stay."""
    if "/" not in name:
        return name
    package, _, kind = name.partition("/")
    return name if "/" in kind else f"{package}/msg/{kind}"
