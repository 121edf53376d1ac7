"""Gives an unfinished MCAP file its end, so that any reader can open it."""

from __future__ import annotations

import contextlib
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pa10d.common.errors import UserError
from pa10d.store import mcap_records as mcap
from pa10d.store.bag_scan import Record, chunk, records
from pa10d.store.bag_writer import message_index
from pa10d.store.entries import new_file

END = "pa10d.end"  # the metadata record by which a writer says how its run ended
CUT = ".cut"  # ending of the file that keeps what was cut off
_STAMP = slice(15, 23)  # log_time within a Message record


@dataclass(frozen=True)
class Repair:
    """What was found when a file was given its end."""

    index: mcap.Index
    finished_before: bool  # nothing was wrong with it
    cut: int  # bytes that were torn
    end: dict[str, str]  # how the run ended, where its writer came to say so


def finish_bag(path: Path) -> Repair:
    """Cut what is torn or damaged off the end and index the rest anew.

    Works in place: a crash on the way leaves an unfinished file, which can be repaired again. What
    is cut off is kept beside it: a damaged byte early in a file may have sound samples behind it.
    """
    index, keep = mcap.Index(), len(mcap.MAGIC)
    pending: list[bytes] = []  # message indexes of the last whole chunk
    end: dict[str, str] = {}
    data_ended = False
    for record in records(path):
        data_ended |= record.opcode == mcap.DATA_END
        if record.opcode == mcap.FOOTER and _closed(path, record.end):
            return Repair(index, True, 0, end)
        if data_ended:
            continue
        if record.opcode == mcap.MESSAGE_INDEX:
            if pending:
                pending.pop()
                keep = record.end
            continue
        try:
            content = mcap.Fields(record.content)
            if record.opcode == mcap.METADATA and content.text() == END:
                end = content.text_map()
            pending = _note(index, record, mcap.Fields(record.content))
        except mcap.BROKEN:
            break
        keep = record.end
    if not index.channels:
        raise UserError(f"{path}: no topic was written before it broke off; nothing to repair")
    size = path.stat().st_size
    with path.open("r+b") as file:
        if size > keep:
            file.seek(keep)
            cut = path.with_suffix(CUT)
            with contextlib.suppress(OSError), new_file(cut) as kept:  # a full disk has no room
                kept.write(file.read())
        file.truncate(keep)
        file.seek(keep)
        missing = b"".join(reversed(pending))
        file.write(missing + index.tail(keep + len(missing)))
        file.flush()
        os.fsync(file.fileno())
    return Repair(index, False, size - keep, end)


def _closed(path: Path, footer_end: int) -> bool:
    with path.open("rb") as file:
        file.seek(footer_end)
        return file.read() == mcap.MAGIC


def _note(index: mcap.Index, record: Record, content: mcap.Fields) -> list[bytes]:
    whole = mcap.RECORD_HEAD.pack(record.opcode, len(record.content)) + record.content
    if record.opcode == mcap.SCHEMA:
        index.schemas.append(whole)
    elif record.opcode == mcap.CHANNEL:
        number, schema = content.number("H"), content.number("H")
        index.add_channel(number, content.text(), _type(index, schema), whole)
    elif record.opcode == mcap.METADATA:
        index.add_metadata(content.text(), record.offset, len(whole))
    elif record.opcode == mcap.CHUNK:
        return _note_chunk(index, record)
    return []


def _type(index: mcap.Index, wanted: int) -> str:
    for whole in index.schemas:
        fields = mcap.Fields(whole[mcap.RECORD_HEAD.size :])
        if fields.number("H") == wanted:
            return fields.text()
    return ""


def _note_chunk(index: mcap.Index, record: Record) -> list[bytes]:
    content = chunk(record)
    indexes: list[bytes] = []
    offsets: dict[int, int] = {}
    counts: dict[int, int] = {}
    at = record.end
    for number, offset, rows in content.messages:
        stamps = np.ascontiguousarray(rows[:, _STAMP]).view("<u8")[:, 0].astype(np.int64)
        indexes.append(message_index(number, stamps, offset, rows.shape[1]))
        offsets[number] = at
        counts[number] = counts.get(number, 0) + len(rows)
        at += len(indexes[-1])
    size = record.end - record.offset
    index.add_chunk(
        record.offset, size, content.span, content.size, offsets, at - record.end, counts
    )
    return indexes[::-1]
