"""SDO beside the cycle: what changes slowly is asked now and then, outputs are set when need be."""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct

import numpy as np
from numpy.typing import NDArray

from backends.frames import frame

EVERY = 0.1  # s between two questions; the budget's SDO reserve holds 270 bits for each
REQUEST = Struct("<BHB4x")
ANSWER = Struct("<BHB4s")
DOWNLOAD = Struct("<BHBI")
UPLOAD, FOUR_BYTES_DOWN, ABORTED = 0x40, 0x23, 0x80
ANSWERED = 0.01  # s after which a node is taken to have answered: it serves one request at a time
SIZES = {0x4F: 1, 0x4B: 2}  # of an expedited answer, by its command
MODE_DISPLAY = 0x6061


class Poll:
    """``temperatures``: (index, °C per count) for each axis that can tell, else None;
    ``modes``: which axes show their mode, and who is told what they show;
        ``on_refusal`` gets axis, index and abort code of a ``set`` that a drive does not take."""

    def __init__(
        self,
        nodes: list[int],
        temperatures: list[tuple[int, float] | None],
        modes: list[bool],
        on_mode: Callable[[int, int], None],
        on_refusal: Callable[[int, int, int], None],
    ) -> None:
        self.values: NDArray[np.float64] = np.full(len(nodes), np.nan)
        self._nodes, self._temperatures = nodes, temperatures
        self._on_mode, self._on_refusal = on_mode, on_refusal
        self._to_set: dict[int, bytes] = {}  # axis -> frame
        self._free = 0.0  # s, from when on another request may go out
        self._questions = [(k, known[0]) for k, known in enumerate(temperatures) if known]
        self.measured = bool(self._questions)
        self._questions += [(k, MODE_DISPLAY) for k, shown in enumerate(modes) if shown]
        self._turn, self._due = 0, 0.0
        self._axis_of = {0x580 + node: k for k, node in enumerate(nodes)}

    def question(self, now: float) -> bytes:
        """The frames to send at ``now`` s, usually none."""
        if self._to_set and now >= self._free:
            self._free = now + ANSWERED
            return self.settings()
        if now < max(self._due, self._free) or not self._questions:
            return b""
        self._due, self._free = now + EVERY, now + ANSWERED
        axis, index = self._questions[self._turn % len(self._questions)]
        self._turn += 1
        return frame(0x600 + self._nodes[axis], REQUEST.pack(UPLOAD, index, 0))

    def set(self, axis: int, index: int, sub: int, value: int) -> None:
        """Write an object of four bytes, before any question; the latest value counts."""
        data = DOWNLOAD.pack(FOUR_BYTES_DOWN, index, sub, value)
        self._to_set[axis] = frame(0x600 + self._nodes[axis], data)

    def settings(self) -> bytes:
        """What waits to be set, to be sent now."""
        packet = b"".join(self._to_set.values())
        self._to_set.clear()
        return packet

    def frame(self, can_id: int, data: bytes) -> None:
        """Take an answer, if this is one."""
        axis = self._axis_of.get(can_id)
        if axis is None or len(data) < ANSWER.size:
            return
        command, index, sub, four = ANSWER.unpack_from(data)
        if command == ABORTED and index not in (MODE_DISPLAY, self._temperature_of(axis)):
            self._on_refusal(axis, index, int.from_bytes(four, "little"))
        if (size := SIZES.get(command)) is None or sub:
            return
        value = int.from_bytes(four[:size], "little", signed=True)
        if index == MODE_DISPLAY:
            self._on_mode(axis, value)
        elif (known := self._temperatures[axis]) is not None and index == known[0]:
            self.values[axis] = value * known[1]

    def _temperature_of(self, axis: int) -> int | None:
        known = self._temperatures[axis]
        return known[0] if known else None
