"""What changes slowly, asked by SDO, one small question now and then beside the cycle."""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct

import numpy as np
from numpy.typing import NDArray

from backends.frames import frame

EVERY = 0.1  # s between two questions; the budget's SDO reserve holds 270 bits for each
REQUEST = Struct("<BHB4x")
ANSWER = Struct("<BHB4s")
UPLOAD = 0x40
SIZES = {0x4F: 1, 0x4B: 2}  # of an expedited answer, by its command
MODE_DISPLAY = 0x6061


class Poll:
    """``temperatures``: (index, °C per count) for each axis that can tell, else None;
    ``modes``: which axes show their mode, and who is told what they show."""

    def __init__(
        self,
        nodes: list[int],
        temperatures: list[tuple[int, float] | None],
        modes: list[bool],
        on_mode: Callable[[int, int], None],
    ) -> None:
        self.values: NDArray[np.float64] = np.full(len(nodes), np.nan)
        self._nodes, self._temperatures, self._on_mode = nodes, temperatures, on_mode
        self._questions = [(k, known[0]) for k, known in enumerate(temperatures) if known]
        self.measured = bool(self._questions)
        self._questions += [(k, MODE_DISPLAY) for k, shown in enumerate(modes) if shown]
        self._turn, self._due = 0, 0.0
        self._axis_of = {0x580 + node: k for k, node in enumerate(nodes)}

    def question(self, now: float) -> bytes:
        """The frame to send at ``now`` s, usually none."""
        if now < self._due or not self._questions:
            return b""
        self._due = now + EVERY
        axis, index = self._questions[self._turn % len(self._questions)]
        self._turn += 1
        return frame(0x600 + self._nodes[axis], REQUEST.pack(UPLOAD, index, 0))

    def frame(self, can_id: int, data: bytes) -> None:
        """Take an answer, if this is one."""
        axis = self._axis_of.get(can_id)
        if axis is None or len(data) < ANSWER.size:
            return
        command, index, sub, four = ANSWER.unpack_from(data)
        if (size := SIZES.get(command)) is None or sub:
            return
        value = int.from_bytes(four[:size], "little", signed=True)
        if index == MODE_DISPLAY:
            self._on_mode(axis, value)
        elif (known := self._temperatures[axis]) is not None and index == known[0]:
            self.values[axis] = value * known[1]
