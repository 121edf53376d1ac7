"""What a packed file becomes, as it says itself, before anything of it is unpacked."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from pa10d.common.errors import UserError
from pa10d.store.csv_locate import most_unpacked

HEAD = 128  # bytes of a MAT file before its first element
COMPRESSED, MATRIX = 15, 14  # kinds of elements of a MAT file
ARROW = b"ARROW1\0\0"
NUMBER = 8  # bytes
CONTINUED = b"\xff\xff\xff\xff"
RECORDS, DICTIONARY = 3, 2  # kinds of an Arrow message's header
KIND, HEADER, BODY_LENGTH = 1, 2, 3  # fields of a message
BUFFERS, COMPRESSION = 2, 3  # fields of a record batch
DICTIONARIES, BATCHES = 2, 3  # fields of a file's footer


def refuse_growth(path: Path, size: int) -> None:
    """UserError, before anything is unpacked, where a file becomes more than a recording does."""
    if size > (most := max(most_unpacked(path), path.stat().st_size)):
        raise UserError(
            f"{path}: {path.stat().st_size} bytes become {size:.3g} bytes of numbers; expected a "
            f"recording, at most {most:.3g}"
        )


def size_of_mat(path: Path) -> int:
    """Bytes of the elements of a MAT file of version 5 to 7, structs and cells with all in them;
    0 for version 4, whose numbers lie open."""
    with path.open("rb") as file:
        head = file.read(HEAD)
        if len(head) < HEAD or head[126:128] not in (b"IM", b"MI"):
            return 0
        order = "<" if head[126:128] == b"IM" else ">"
        return sum(_elements(file, order))


def _elements(file: BinaryIO, order: str) -> Iterator[int]:
    tag = struct.Struct(f"{order}II")
    while len(raw := file.read(tag.size)) == tag.size:
        kind, size = tag.unpack(raw)
        begin = file.tell()
        if kind == COMPRESSED:
            inner = zlib.decompressobj().decompress(file.read(min(size, 4096)), tag.size)
            yield tag.unpack(inner)[1] if len(inner) == tag.size else size
        elif kind == MATRIX:
            yield size
        file.seek(begin + size)


def size_of_parquet(about: Any) -> int:
    """Bytes of all leaves, those of lists among them, by a Parquet file's own metadata."""
    return sum(
        NUMBER * about.row_group(group).column(k).num_values
        for group in range(about.num_row_groups)
        for k in range(about.num_columns)
    )


def size_of_arrow(path: Path) -> int:
    """Bytes of the buffers of an Arrow file or stream, each of which says what it unpacks to."""
    with path.open("rb") as file:
        if file.read(len(ARROW)) == ARROW:
            return sum(_unpacked(file, *block) for block in _blocks(file))
        return sum(_unpacked(file, *block) for block in _messages(file))


def _blocks(file: BinaryIO) -> Iterator[tuple[int, int]]:
    """Where the messages of a file begin and how long they are without their bodies, by its
    footer."""
    tail = struct.Struct("<i6s")
    end = file.seek(-tail.size, os.SEEK_END)
    size, _ = tail.unpack(file.read(tail.size))
    file.seek(end - size)
    footer = _root(file.read(size))
    for field in (DICTIONARIES, BATCHES):
        for offset, length, _ in footer.structs(field, "<qi4xq"):
            yield offset, length


def _messages(file: BinaryIO) -> Iterator[tuple[int, int]]:
    """The same of a stream, in which one follows another."""
    at = 0
    while True:
        file.seek(at)
        head = file.read(8)
        if len(head) < 8:
            return
        marked = head.startswith(CONTINUED)
        (size,) = struct.unpack_from("<i", head, 4 if marked else 0)
        if size <= 0:
            return
        length = size + (8 if marked else 4)
        yield at, length
        file.seek(at + length - size)
        body = _root(file.read(size)).long(BODY_LENGTH)
        if body < 0:
            raise ValueError(f"a message of {body} bytes")
        at += length + body


def _unpacked(file: BinaryIO, offset: int, length: int) -> int:
    """Bytes of one message's buffers."""
    file.seek(offset)
    raw = file.read(length)
    message = _root(raw[8 if raw.startswith(CONTINUED) else 4 :])
    kind, batch = message.byte(KIND), message.table(HEADER)
    if kind == DICTIONARY and batch is not None:
        batch = batch.table(1)
    if kind not in (RECORDS, DICTIONARY) or batch is None:
        return 0
    if not batch.has(COMPRESSION):
        return message.long(BODY_LENGTH)
    total = 0
    for begin, size in batch.structs(BUFFERS, "<qq"):
        if size >= NUMBER:
            file.seek(offset + length + begin)
            (whole,) = struct.unpack("<q", file.read(NUMBER))
            total += size if whole < 0 else whole  # -1: left as it was
    return total


def _root(data: bytes) -> _Table:
    return _Table(data, struct.unpack_from("<I", data)[0])


class _Table:
    """One of a flatbuffer's, as far as Arrow's messages need it."""

    def __init__(self, data: bytes, at: int) -> None:
        self._data, self._at = data, at
        self._fields = at - struct.unpack_from("<i", data, at)[0]
        self._size = struct.unpack_from("<H", data, self._fields)[0]

    def has(self, field: int) -> bool:
        """Whether the field was written."""
        return self._place(field) is not None

    def byte(self, field: int) -> int:
        """Its value, 0 where it was left out."""
        place = self._place(field)
        return 0 if place is None else self._data[place]

    def table(self, field: int) -> _Table | None:
        """The one that the field points to."""
        place = self._place(field)
        return None if place is None else _Table(self._data, self._pointed(place))

    def long(self, field: int) -> int:
        """Its value in 64 bits, 0 where it was left out."""
        place = self._place(field)
        return 0 if place is None else int(struct.unpack_from("<q", self._data, place)[0])

    def structs(self, field: int, form: str) -> Iterator[tuple[int, ...]]:
        """Those of a vector, each as ``form`` has it."""
        place = self._place(field)
        if place is not None:
            begin = self._pointed(place)
            end = begin + 4 + struct.calcsize(form) * struct.unpack_from("<I", self._data, begin)[0]
            yield from struct.iter_unpack(form, self._data[begin + 4 : end])

    def _pointed(self, place: int) -> int:
        return int(place + struct.unpack_from("<I", self._data, place)[0])

    def _place(self, field: int) -> int | None:
        entry = 4 + 2 * field
        if entry + 2 > self._size:
            return None
        offset = struct.unpack_from("<H", self._data, self._fields + entry)[0]
        return self._at + offset if offset else None
