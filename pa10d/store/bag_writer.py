"""Writes one MCAP file: channels of fixed-size messages, in small chunks, nothing compressed."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from pa10d.store import mcap_records as mcap
from pa10d.store.ros_messages import DEFINITIONS, Template

Stamps = NDArray[np.int64]
INDEX_ENTRY = np.dtype([("stamp", "<u8"), ("offset", "<u8")])


def message_dtype(template: Template) -> np.dtype:
    """A whole Message record of this template, its fields at their places."""
    names = ["channel", "sequence", "log_time", "publish_time", *template.fields]
    offsets = [9, 11, 15, 23, *(31 + at for _, at in template.fields.values())]
    formats = ["<u2", "<u4", "<u8", "<u8", *(code for code, _ in template.fields.values())]
    size = mcap.MESSAGE_HEAD.size + len(template.cdr)
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": size})


class TopicWriter:
    """One topic: turns stamps and values into the bytes of its Message records."""

    def __init__(self, number: int, template: Template) -> None:
        self.number = number
        self.written = 0
        self._dtype = message_dtype(template)
        head = mcap.MESSAGE_HEAD.pack(
            mcap.MESSAGE, self._dtype.itemsize - mcap.RECORD_HEAD.size, number, 0, 0, 0
        )
        self._template = np.frombuffer(head + template.cdr, np.uint8)

    def pack(self, stamps: Stamps, values: Mapping[str, NDArray[np.float64]]) -> bytes:
        """``stamps`` (k,) in ns, ``values`` field -> (k,) or (k, n)."""
        k = len(stamps)
        raw = np.empty((k, self._dtype.itemsize), np.uint8)
        raw[:] = self._template
        block = raw.view(self._dtype)[:, 0]
        block["sequence"] = np.arange(self.written, self.written + k)
        block["log_time"] = block["publish_time"] = stamps
        if "sec" in self._dtype.fields:  # type: ignore[operator]
            block["sec"], block["nanosec"] = np.divmod(stamps, 1_000_000_000)
        for name, value in values.items():
            block[name] = value
        self.written += k
        return raw.tobytes()

    def index(self, stamps: Stamps, offset: int) -> bytes:
        """The MessageIndex record of a block that begins ``offset`` bytes into its chunk."""
        return message_index(self.number, stamps, offset, self._dtype.itemsize)


def message_index(number: int, stamps: Stamps, offset: int, stride: int) -> bytes:
    """A MessageIndex record for equally long messages in a row."""
    entries = np.empty(len(stamps), INDEX_ENTRY)
    entries["stamp"] = stamps
    entries["offset"] = offset + stride * np.arange(len(stamps))
    body = entries.tobytes()
    return mcap.record(mcap.MESSAGE_INDEX, struct.pack("<HI", number, len(body)) + body)


@dataclass(frozen=True)
class MessageBlock:
    """Messages of one channel: stamps (k,) ns and field -> (k,) or (k, n)."""

    channel: TopicWriter
    stamps: Stamps
    values: Mapping[str, NDArray[np.float64]]


class BagWriter:
    """One MCAP file, written from start to end. Every call leaves whole records behind it."""

    def __init__(self, file: BinaryIO, library: str) -> None:
        self._file = file
        self._schemas: dict[str, int] = {}
        self.index = mcap.Index()
        self._at = 0
        self._write(mcap.header(library))

    def add_channel(
        self, topic: str, template: Template, notes: Mapping[str, str] | None = None
    ) -> TopicWriter:
        """Announce a topic; all topics are announced before the first chunk."""
        if template.type not in self._schemas:
            self._schemas[template.type] = len(self._schemas) + 1
            self.index.schemas.append(
                mcap.schema(self._schemas[template.type], template.type, DEFINITIONS[template.type])
            )
            self._write(self.index.schemas[-1])
        number = len(self.index.channels) + 1
        notes = {"offered_qos_profiles": "", **(notes or {})}
        whole = mcap.channel(number, self._schemas[template.type], topic, notes)
        self.index.add_channel(number, topic, template.type, whole)
        self._write(whole)
        return TopicWriter(number, template)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write a named map of strings."""
        data = mcap.metadata(name, values)
        self.index.add_metadata(name, self._at, len(data))
        self._write(data)

    def write_chunk(self, blocks: Sequence[MessageBlock]) -> None:
        """Write these blocks as one chunk with its message indexes, in one go."""
        blocks = [block for block in blocks if len(block.stamps)]
        if not blocks:
            return
        packed = [block.channel.pack(block.stamps, block.values) for block in blocks]
        starts = np.concatenate([[0], np.cumsum([len(part) for part in packed])])
        start = min(int(block.stamps.min()) for block in blocks)
        end = max(int(block.stamps.max()) for block in blocks)
        crc, size = 0, int(starts[-1])
        for part in packed:
            crc = zlib.crc32(part, crc)
        head = mcap.CHUNK_HEAD.pack(start, end, size, crc) + mcap.text("") + struct.pack("<Q", size)
        length = mcap.RECORD_HEAD.size + len(head) + size
        indexes = [b.channel.index(b.stamps, int(s)) for b, s in zip(blocks, starts, strict=False)]
        at, offsets = self._at + length, {}
        for block, index in zip(blocks, indexes, strict=True):
            offsets[block.channel.number] = at
            at += len(index)
        self.index.add_chunk(
            self._at, length, (start, end), size, offsets, sum(map(len, indexes)),
            {b.channel.number: len(b.stamps) for b in blocks},
        )  # fmt: skip
        record_head = mcap.RECORD_HEAD.pack(mcap.CHUNK, len(head) + size)
        self._write(b"".join([record_head, head, *packed, *indexes]))

    def flush(self) -> None:
        """Hand everything written so far to the operating system."""
        self._file.flush()

    def close(self) -> None:
        """Write the summary; the file itself stays open."""
        self._write(self.index.tail(self._at))
        self.flush()

    def _write(self, data: bytes) -> None:
        self._file.write(data)
        self._at += len(data)
