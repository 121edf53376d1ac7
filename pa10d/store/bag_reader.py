"""Reads an MCAP file of fixed-size messages into arrays, one set per topic."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.store import mcap_records as mcap
from pa10d.store.bag_scan import Rows, chunk, records
from pa10d.store.bag_writer import message_dtype
from pa10d.store.entries import explained
from pa10d.store.ros_messages import Template, parse


@dataclass
class Topic:
    """All messages of one topic."""

    name: str
    type: str
    notes: dict[str, str]
    names: tuple[str, ...] = ()  # joint names (JointState)
    stamps: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))  # ns
    values: dict[str, NDArray[np.float64]] = field(default_factory=dict)  # (k,) or (k, n)


@dataclass
class Bag:
    """A file in memory."""

    topics: dict[str, Topic]
    metadata: dict[str, dict[str, str]]
    complete: bool  # it ends with a footer


class _Collector:
    """Gathers the messages of one channel, block by block."""

    def __init__(self, topic: Topic) -> None:
        self.topic = topic
        self._template: Template | None = None
        self._dtype = np.dtype([])
        self._blocks: list[dict[str, NDArray]] = []

    def add(self, rows: Rows) -> None:
        if self._template is None:
            self._template = parse(self.topic.type, rows[0, mcap.MESSAGE_HEAD.size :].tobytes())
            self._dtype = message_dtype(self._template)
            self.topic.names = self._template.names
        if rows.shape[1] != self._dtype.itemsize:
            raise ValueError(f"messages on {self.topic.name} that change their size")
        block = np.ascontiguousarray(rows).view(self._dtype)[:, 0]
        wanted = ["log_time", *(f for f in self._template.fields if f not in ("sec", "nanosec"))]
        self._blocks.append({name: block[name].copy() for name in wanted})

    def finish(self) -> Topic:
        if self._blocks:
            joined = {
                name: np.concatenate([block[name] for block in self._blocks])
                for name in self._blocks[0]
            }
            self._blocks.clear()
            self.topic.stamps = joined.pop("log_time").astype(np.int64)
            self.topic.values = joined
        return self.topic


def read_bag(path: Path) -> Bag:
    """Everything in the file up to its end or to where it is torn."""
    types: dict[int, str] = {}
    collectors: dict[int, _Collector] = {}
    metadata: dict[str, dict[str, str]] = {}
    complete = False
    try:
        for record in records(path):
            content = mcap.Fields(record.content)
            if record.opcode == mcap.SCHEMA:
                number = content.number("H")
                types[number] = content.text()
            elif record.opcode == mcap.CHANNEL:
                _add_channel(content, types, collectors)
            elif record.opcode == mcap.METADATA:
                name = content.text()
                metadata[name] = content.text_map()
            elif record.opcode == mcap.CHUNK:
                for number, _, rows in chunk(record).messages:
                    collectors[number].add(rows)
            complete = record.opcode == mcap.FOOTER
    except mcap.BROKEN as error:
        raise UserError(f"{path}: damaged ({explained(error)}); expected a run of pa10d") from error
    topics = [collector.finish() for collector in collectors.values()]
    return Bag({topic.name: topic for topic in topics}, metadata, complete)


def _add_channel(
    content: mcap.Fields, types: dict[int, str], collectors: dict[int, _Collector]
) -> None:
    number, schema = content.number("H"), content.number("H")
    name, _, notes = content.text(), content.text(), content.text_map()
    if number not in collectors:
        collectors[number] = _Collector(Topic(name, types[schema], notes))
