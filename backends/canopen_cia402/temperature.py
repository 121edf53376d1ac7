"""Motor temperatures by SDO, one small question now and then beside the cycle."""

from __future__ import annotations

from struct import Struct

import numpy as np
from numpy.typing import NDArray

from backends.frames import frame

EVERY = 0.1  # s between two questions; the budget's SDO reserve holds 270 bits for each
REQUEST = Struct("<BHB4x")
ANSWER = Struct("<BHBh")
UPLOAD, TWO_BYTES = 0x40, 0x4B


class TemperaturePoll:
    """``objects`` has (index, °C per count) for each axis that can tell, else None."""

    def __init__(self, nodes: list[int], objects: list[tuple[int, float] | None]) -> None:
        self.values: NDArray[np.float64] = np.full(len(nodes), np.nan)
        self._nodes, self._objects = nodes, objects
        self._axes = [k for k, known in enumerate(objects) if known]
        self._turn, self._due = 0, 0.0
        self._axis_of = {0x580 + nodes[k]: k for k in self._axes}

    @property
    def measured(self) -> bool:
        return bool(self._axes)

    def question(self, now: float) -> bytes:
        """The frame to send at ``now`` s, usually none."""
        if now < self._due or not self._axes:
            return b""
        self._due = now + EVERY
        axis = self._axes[self._turn % len(self._axes)]
        self._turn += 1
        known = self._objects[axis]
        assert known is not None
        return frame(0x600 + self._nodes[axis], REQUEST.pack(UPLOAD, known[0], 0))

    def frame(self, can_id: int, data: bytes) -> None:
        """Take an answer, if this is one."""
        axis = self._axis_of.get(can_id)
        if axis is None or len(data) < ANSWER.size:
            return
        known = self._objects[axis]
        command, index, _, value = ANSWER.unpack_from(data)
        if known is not None and command == TWO_BYTES and index == known[0]:
            self.values[axis] = value * known[1]
