"""Goes through an MCAP file from its start, so that an unfinished one is read just as well.

The summary at the end is never relied upon: whole records are taken in turn until the file ends,
is torn, or fails its checksum.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.store import mcap_records as mcap
from pa10d.store.entries import refuse_links

Rows = NDArray[np.uint8]  # (k, size): k equally long Message records of one channel


@dataclass(frozen=True)
class Record:
    """One whole record: where it begins, its kind and content."""

    offset: int
    opcode: int
    content: bytes

    @property
    def end(self) -> int:
        """The first byte behind the record."""
        return self.offset + mcap.RECORD_HEAD.size + len(self.content)


@dataclass(frozen=True)
class Chunk:
    """The messages of one chunk, checked."""

    span: tuple[int, int]  # ns
    size: int
    messages: list[tuple[int, int, Rows]]  # channel, offset in the chunk, records


def records(path: Path) -> Iterator[Record]:
    """Whole records up to the footer or to where the file is torn."""
    refuse_links(path, "file")
    with path.open("rb") as file:
        if file.read(len(mcap.MAGIC)) != mcap.MAGIC:
            raise UserError(f"{path}: not an MCAP file; expected a run of pa10d")
        yield from _records(file, path.stat().st_size)


def _records(file: BinaryIO, size: int) -> Iterator[Record]:
    at = len(mcap.MAGIC)
    while at + mcap.RECORD_HEAD.size <= size:
        opcode, length = mcap.RECORD_HEAD.unpack(file.read(mcap.RECORD_HEAD.size))
        if not mcap.HEADER <= opcode <= mcap.DATA_END or at + 9 + length > size:
            return
        content = file.read(length)
        if len(content) < length or (opcode == mcap.CHUNK and not _sound(content)):
            return
        yield Record(at, opcode, content)
        if opcode == mcap.FOOTER:
            return
        at += mcap.RECORD_HEAD.size + length


def _sound(content: bytes) -> bool:
    """Whether a chunk is as its writer left it."""
    try:
        size, crc, compression, body = _chunk_parts(content)
    except mcap.BROKEN:
        return False
    if compression:
        raise UserError(f"a chunk is compressed ({compression}); expected a run of pa10d")
    return len(body) == size and (not crc or zlib.crc32(body) == crc)


def _chunk_parts(content: bytes) -> tuple[int, int, str, memoryview]:
    _, _, size, crc = mcap.CHUNK_HEAD.unpack_from(content)
    fields = mcap.Fields(content)
    fields.at = mcap.CHUNK_HEAD.size
    compression = fields.text()
    length = fields.number("Q")
    return size, crc, compression, memoryview(content)[fields.at : fields.at + length]


def chunk(record: Record) -> Chunk:
    """The messages of a chunk record, those of equal length and channel in a row together."""
    start, end, size, _ = mcap.CHUNK_HEAD.unpack_from(record.content)
    body = _chunk_parts(record.content)[3]
    return Chunk((start, end), size, list(_groups(body)))


def _groups(body: memoryview) -> Iterator[tuple[int, int, Rows]]:
    """ValueError where a record does not fit into its chunk."""
    data, at = np.frombuffer(body, np.uint8), 0
    while at + mcap.RECORD_HEAD.size <= len(data):
        opcode, length = mcap.RECORD_HEAD.unpack_from(body, at)
        size, count = mcap.RECORD_HEAD.size + length, 1
        if size > len(data) - at:
            raise ValueError("a record longer than its chunk")
        if opcode == mcap.MESSAGE:
            if size < mcap.MESSAGE_HEAD.size:
                raise ValueError("a message without stamps")
            rows = data[at : at + (len(data) - at) // size * size].reshape(-1, size)
            count = _alike(rows[:, :11])
            yield int(rows[0, 9]) | int(rows[0, 10]) << 8, at, rows[:count]
        at += count * size


def _alike(heads: Rows) -> int:
    """How many rows from the first on are equal to it; looks no further than twice as many."""
    found, step = 1, 64
    while found < len(heads):
        same = (heads[found : found + step] == heads[0]).all(axis=1)
        if not same.all():
            return found + int(same.argmin())
        found, step = found + len(same), 2 * step
    return found
