"""Single-producer ring of records in memory that other processes read without any lock.

The writer never waits. A row is announced by the count that is stored after it; every row also
carries its own sequence number, taken away while it is being rewritten, so that a reader that was
overtaken notices. Memory is a file in a memory file system, or private memory for tests.
"""

from __future__ import annotations

import json
import mmap
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.control.record import RecordLayout

Array = NDArray[np.float64]

MAGIC, VERSION = 0x70613130_72696E67, 1
SLOTS = 32  # int64 in the header
NOTE = 1 << 16  # bytes for the last words (the fault, in JSON): more than the longest has
_MAGIC, _VERSION, _JOINTS, _CAPACITY, _WRITTEN, _TAKEN, _WRITER, _PERIOD_NS, _NOTE_LENGTH = range(9)


class Ring:
    """Rows of RecordLayout; see ``create`` and ``attach``."""

    def __init__(self, memory: mmap.mmap | bytearray) -> None:
        self._memory = memory
        self._header = np.frombuffer(memory, dtype=np.int64, count=SLOTS)
        if self._header[_MAGIC] != MAGIC or self._header[_VERSION] != VERSION:
            raise ValueError("not a ring of this version")
        self.layout = RecordLayout(int(self._header[_JOINTS]))
        self.capacity = int(self._header[_CAPACITY])
        self._rows = np.frombuffer(
            memory, np.float64, self.capacity * self.layout.width, SLOTS * 8 + NOTE
        ).reshape(self.capacity, self.layout.width)

    @staticmethod
    def create(joints: int, capacity: int, period: float, path: Path | None = None) -> Ring:
        """A new ring; with a path it can be shared."""
        size = SLOTS * 8 + NOTE + 8 * capacity * RecordLayout(joints).width
        memory: mmap.mmap | bytearray = bytearray(size)
        if path is not None:
            with path.open("xb+") as file:
                os.posix_fallocate(file.fileno(), 0, size)
                memory = mmap.mmap(file.fileno(), size)
        header = np.frombuffer(memory, dtype=np.int64, count=SLOTS)
        header[_JOINTS], header[_CAPACITY] = joints, capacity
        header[_PERIOD_NS] = round(period * 1e9)
        header[_VERSION] = VERSION
        header[_MAGIC] = MAGIC
        return Ring(memory)

    @staticmethod
    def attach(path: Path) -> Ring:
        """A ring that another process made."""
        with path.open("rb+") as file:
            return Ring(mmap.mmap(file.fileno(), 0))

    @property
    def period(self) -> float:
        """s between records."""
        return int(self._header[_PERIOD_NS]) * 1e-9

    @property
    def written(self) -> int:
        """How many records were ever written."""
        return int(self._header[_WRITTEN])

    @property
    def writer(self) -> int:
        """Process id of the writer, 0: none yet."""
        return int(self._header[_WRITER])

    @writer.setter
    def writer(self, pid: int) -> None:
        self._header[_WRITER] = pid

    @property
    def taken(self) -> int:
        """How many records the recorder has dealt with."""
        return int(self._header[_TAKEN])

    @taken.setter
    def taken(self, count: int) -> None:
        self._header[_TAKEN] = count

    def append(self, row: Array) -> None:
        """Write one row; its sequence number is set here."""
        count = int(self._header[_WRITTEN])
        row[0] = count
        place = self._rows[count % self.capacity]
        place[0] = -1.0
        place[1:] = row[1:]
        place[0] = count
        self._header[_WRITTEN] = count + 1

    def read(self, start: int, stop: int | None = None) -> tuple[Array, int]:
        """Copies of the records start … stop-1 that are still there → rows, lost.

        ``lost`` of the first ones were overwritten before they could be read.
        """
        stop = self.written if stop is None else min(stop, self.written)
        first = max(start, stop - self.capacity)
        if stop <= first:
            return np.empty((0, self.layout.width)), 0
        numbers = np.arange(first, stop)
        places = numbers % self.capacity
        rows = self._rows[places]
        # read again: a row may have begun to be overwritten after its number was copied
        kept = rows[(rows[:, 0] == numbers) & (self._rows[places, 0] == numbers)]
        return kept, (stop - start) - len(kept)

    def last(self) -> Array | None:
        """The newest record, or None."""
        for _ in range(4):
            count = self.written
            if count == 0:
                return None
            place = self._rows[(count - 1) % self.capacity]
            row = place.copy()
            if row[0] == count - 1 == place[0]:
                return row
        return None

    def say(self, note: JsonObject | None) -> None:
        """Leave last words that outlive the writer."""
        text = b"" if note is None else json.dumps(note).encode()[:NOTE]
        self._header[_NOTE_LENGTH] = 0
        self._memory[SLOTS * 8 : SLOTS * 8 + len(text)] = text
        self._header[_NOTE_LENGTH] = len(text)

    def said(self) -> JsonObject | None:
        """The last words."""
        length = int(self._header[_NOTE_LENGTH])
        text = bytes(self._memory[SLOTS * 8 : SLOTS * 8 + length])
        try:
            return json.loads(text) if text else None
        except ValueError:
            return None
