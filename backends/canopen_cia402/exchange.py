"""The cycle on raw frames: what came in which cycle, and the frames that go out.

Plain struct in the loop's thread: a few microseconds for seven axes.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from dataclasses import dataclass
from struct import Struct

import numpy as np

from backends.canopen_cia402.layout import Layout
from backends.frames import SIZE, frame

HEAD = Struct("=IB")  # id and flags, length
DATA = 8  # offset of the data in a frame
SYNC_FRAME = frame(0x80)


@dataclass
class Counters:
    """What was not as it should be, since the last reset."""

    late: int = 0
    repeated: int = 0
    missing: int = 0


@dataclass
class AxisInput:
    """The last TPDO of one axis."""

    position: int = 0  # counts
    status: int = 0
    cycle: int = 0  # in which it came
    known: bool = False  # whether one came at all
    previous: int | None = None  # position in the one before
    repeats: int = 0  # cycles in a row with more than one TPDO
    short: int | None = None  # length of a frame that was too short
    late: int = 0  # TPDOs that came before the SYNC of their cycle, since the one before
    owed: int = 0  # answers to earlier SYNCs that may come yet

    def catches_up(self, missed: int) -> int:
        """It answers again, after so many cycles without: answers of these that came by now."""
        self.owed += missed
        late, self.late = self.late, 0
        return self.pays(late)

    def pays(self, extra: int) -> int:
        """How many of so many TPDOs beside the one of a cycle answer earlier SYNCs: a drive that
        stood still, or a bus that held frames back, gives them in a batch, a period each."""
        paid = min(extra, self.owed)
        self.owed -= paid
        return paid


class Exchange:
    """TPDOs in, RPDOs out, for all axes of one bus."""

    def __init__(
        self,
        nodes: list[int],
        feedback: list[Layout],
        command: list[Layout],
        other: Callable[[int, bytes], None],
        stale_cycles: int,
    ) -> None:
        """``other`` gets every frame that is not a TPDO of the cycle: id with flags, data."""
        self.axes = [AxisInput() for _ in nodes]
        self.counters = Counters()
        self.cycle = 0
        self._feedback, self._command, self._other = feedback, command, other
        self._stale_cycles = stale_cycles
        self._axis_of = {0x180 + node: k for k, node in enumerate(nodes)}
        self._waiting: set[int] = set()
        self._repeated: set[int] = set()  # axes with more than one TPDO in this cycle
        self._repeating: set[int] = set()  # … in the last one
        n = len(nodes)
        self._raw = array("q", [0] * (5 * n))  # faster to write than numpy, shares its memory
        self.position, self.torque, self.status, self.seen_in, self.answers = np.frombuffer(
            self._raw, np.int64
        ).reshape(5, n)  # counts, per mille, word, cycle; answers since the cycle before
        self._out = bytearray().join(
            frame(0x200 + node, bytes(layout.size))
            for node, layout in zip(nodes, command, strict=True)
        )

    @property
    def complete(self) -> bool:
        """Whether every axis that was expected has answered in this cycle."""
        return not self._waiting

    @property
    def begun(self) -> bool:
        """Whether any axis has answered in this cycle."""
        return any(seen.cycle == self.cycle for seen in self.axes)

    @property
    def overdue(self) -> bool:
        """Whether every axis still waited for was silent in the last cycle already."""
        return all(self.axes[axis].cycle < self.cycle - 1 for axis in self._waiting)

    def begin(self) -> None:
        """A new cycle. Axes that were silent for too long are no longer waited for."""
        self.cycle += 1
        alive = self.cycle - self._stale_cycles
        self._waiting = {k for k, seen in enumerate(self.axes) if seen.cycle >= alive}
        if not self._waiting:
            self._waiting = set(range(len(self.axes)))
        if self._repeated or self._repeating:
            for axis, seen in enumerate(self.axes):
                seen.repeats = seen.repeats + 1 if axis in self._repeated else 0
            self._repeated, self._repeating = set(), self._repeated

    def expect(self, axis: int) -> None:
        """The axis was set up anew: wait for its answers again."""
        self.axes[axis] = AxisInput(cycle=self.cycle)
        self._raw[axis + 3 * len(self.axes)] = self.cycle

    def take(self, packet: bytes, late: bool = False) -> None:
        """Sort in received frames; ``late``: they came before this cycle's SYNC."""
        for offset in range(0, len(packet) - SIZE + 1, SIZE):
            can_id, length = HEAD.unpack_from(packet, offset)
            axis = self._axis_of.get(can_id)
            if axis is None:
                start = offset + DATA
                self._other(can_id, packet[start : start + min(length, 8)])
            elif length < self._feedback[axis].size:
                self.axes[axis].short = length
            elif late:
                self.counters.late += 1
                self.axes[axis].late += 1
            else:
                self._take_tpdo(axis, packet, offset + DATA)

    def pack(self, controlwords: list[int], per_mille: list[int]) -> bytes:
        """The RPDOs of all axes."""
        out, at = self._out, DATA
        for layout, word, torque in zip(self._command, controlwords, per_mille, strict=True):
            if layout.order == (0, 1):
                layout.struct.pack_into(out, at, word, torque)
            else:
                layout.struct.pack_into(out, at, torque, word)
            at += SIZE
        return bytes(out)

    def _take_tpdo(self, axis: int, packet: bytes, start: int) -> None:
        layout, seen = self._feedback[axis], self.axes[axis]
        values = layout.struct.unpack_from(packet, start)
        position, torque, status = layout.order
        raw, n = self._raw, len(self.axes)
        if seen.cycle == self.cycle:
            self.counters.repeated += 1
            self._repeated.add(axis)
            raw[axis + 4 * n] += seen.pays(1)
        else:
            missed = self.cycle - seen.cycle - 1
            raw[axis + 4 * n] = 1 + seen.catches_up(missed) if missed or seen.late else 1
            if seen.known:
                seen.previous = seen.position
        seen.position, seen.status = values[position], values[status]
        seen.cycle, seen.known = self.cycle, True
        raw[axis], raw[axis + n] = seen.position, values[torque]
        raw[axis + 2 * n], raw[axis + 3 * n] = seen.status, self.cycle
        self._waiting.discard(axis)
