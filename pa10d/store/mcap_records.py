"""MCAP records as bytes (https://mcap.dev/spec): the part of the format that runs need."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field

BROKEN = (ValueError, KeyError, IndexError, OverflowError, struct.error)  # by damaged bytes
MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 1, 2, 3, 4, 5, 6
MESSAGE_INDEX, CHUNK_INDEX, STATISTICS, METADATA = 7, 8, 0x0B, 0x0C
METADATA_INDEX, SUMMARY_OFFSET, DATA_END = 0x0D, 0x0E, 0x0F

RECORD_HEAD = struct.Struct("<BQ")  # opcode, length of what follows
CHUNK_HEAD = struct.Struct("<QQQI")  # start, end, size, CRC; then compression and the records
MESSAGE_HEAD = struct.Struct("<BQHIQQ")  # with the record head: channel, sequence, two stamps


def record(opcode: int, content: bytes) -> bytes:
    """A whole record."""
    return RECORD_HEAD.pack(opcode, len(content)) + content


def text(value: str) -> bytes:
    """A length-prefixed string."""
    encoded = value.encode()
    return struct.pack("<I", len(encoded)) + encoded


def text_map(values: Mapping[str, str]) -> bytes:
    """A map of strings."""
    body = b"".join(text(key) + text(value) for key, value in values.items())
    return struct.pack("<I", len(body)) + body


def counts(values: Mapping[int, int]) -> bytes:
    """A map of channel ids to numbers."""
    body = b"".join(struct.pack("<HQ", key, value) for key, value in values.items())
    return struct.pack("<I", len(body)) + body


def header(library: str) -> bytes:
    """The start of a file."""
    return MAGIC + record(HEADER, text("ros2") + text(library))


def schema(number: int, name: str, definition: str) -> bytes:
    """A message type."""
    return record(
        SCHEMA, struct.pack("<H", number) + text(name) + text("ros2msg") + text(definition)
    )


def channel(number: int, schema_number: int, topic: str, notes: Mapping[str, str]) -> bytes:
    """A topic."""
    head = struct.pack("<HH", number, schema_number)
    return record(CHANNEL, head + text(topic) + text("cdr") + text_map(notes))


def metadata(name: str, values: Mapping[str, str]) -> bytes:
    """A named map of strings."""
    return record(METADATA, text(name) + text_map(values))


class Fields:
    """Reads the fields of one record's content in turn."""

    def __init__(self, content: bytes) -> None:
        self.content, self.at = content, 0

    def number(self, code: str) -> int:
        """The next fixed-size number (a struct code)."""
        (value,) = struct.unpack_from("<" + code, self.content, self.at)
        self.at += struct.calcsize("<" + code)
        return int(value)

    def text(self) -> str:
        """The next string."""
        size = self.number("I")
        self.at += size
        if self.at > len(self.content):
            raise ValueError("a text longer than its record")
        return self.content[self.at - size : self.at].decode()

    def text_map(self) -> dict[str, str]:
        """The next map of strings."""
        end = self.number("I") + self.at
        values = {}
        while self.at < end:
            key = self.text()
            values[key] = self.text()
        return values


@dataclass
class Index:
    """What the end of a file says about the rest of it; a repair builds it anew."""

    schemas: list[bytes] = field(default_factory=list)  # whole records
    channels: list[bytes] = field(default_factory=list)
    topics: dict[int, tuple[str, str]] = field(default_factory=dict)  # channel id -> name, type
    chunks: list[bytes] = field(default_factory=list)  # whole ChunkIndex records
    metadata: list[bytes] = field(default_factory=list)  # whole MetadataIndex records
    messages: dict[int, int] = field(default_factory=dict)  # channel id -> number of messages
    start: int | None = None  # ns
    end: int = 0

    def add_channel(self, number: int, topic: str, message_type: str, whole: bytes) -> None:
        """Note a channel and its record."""
        self.channels.append(whole)
        self.topics[number] = (topic, message_type)
        self.messages[number] = 0

    def add_metadata(self, name: str, offset: int, length: int) -> None:
        """Note a metadata record that begins at ``offset``."""
        self.metadata.append(
            record(METADATA_INDEX, struct.pack("<QQ", offset, length) + text(name))
        )

    def add_chunk(
        self, offset: int, length: int, span: tuple[int, int], size: int,
        index_offsets: Mapping[int, int], index_length: int, messages: Mapping[int, int],
    ) -> None:  # fmt: skip
        """Note an uncompressed chunk: where it and its message indexes stand, what it spans."""
        content = struct.pack("<QQQQ", *span, offset, length) + counts(index_offsets)
        content += struct.pack("<Q", index_length) + text("") + struct.pack("<QQ", size, size)
        self.chunks.append(record(CHUNK_INDEX, content))
        for number, n in messages.items():
            self.messages[number] = self.messages.get(number, 0) + n
        self.start = span[0] if self.start is None else min(self.start, span[0])
        self.end = max(self.end, span[1])

    def tail(self, offset: int) -> bytes:
        """DataEnd, summary, footer and closing magic for a file whose data end at ``offset``."""
        data_end = record(DATA_END, struct.pack("<I", 0))
        summary_start = offset + len(data_end)
        groups = {
            SCHEMA: b"".join(self.schemas),
            CHANNEL: b"".join(self.channels),
            STATISTICS: self._statistics(),
            CHUNK_INDEX: b"".join(self.chunks),
            METADATA_INDEX: b"".join(self.metadata),
        }
        offsets, at = b"", summary_start
        for opcode, group in groups.items():
            if group:
                offsets += record(SUMMARY_OFFSET, struct.pack("<BQQ", opcode, at, len(group)))
            at += len(group)
        summary = b"".join(groups.values()) + offsets
        footer = RECORD_HEAD.pack(FOOTER, 20) + struct.pack("<QQ", summary_start, at)
        crc = zlib.crc32(summary + footer)
        return data_end + summary + footer + struct.pack("<I", crc) + MAGIC

    def _statistics(self) -> bytes:
        numbers = struct.pack(
            "<QHIIIIQQ", sum(self.messages.values()), len(self.schemas), len(self.channels), 0,
            len(self.metadata), len(self.chunks), self.start or 0, self.end,
        )  # fmt: skip
        return record(STATISTICS, numbers + counts(self.messages))
