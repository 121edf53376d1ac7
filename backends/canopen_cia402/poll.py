"""SDO beside the cycle: what changes slowly is asked now and then, outputs are set when need be.

Temperatures and modes are asked in turn, and, twice as often, what gives a drive's numbers their
meaning: nobody but us may change that while the arm is held.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from itertools import zip_longest
from struct import Struct

import numpy as np
from numpy.typing import NDArray

from backends.frames import frame

SLOWEST, QUICKEST = 0.1, 0.02  # s between two questions
QUESTION = 270  # bits on the wire, with its answer
SHARE = 0.5  # of the SDO reserve that questions use; the rest is for EMCY and other tools
FIXED_IN_A_ROW = 2  # questions after what is fixed, to one after what changes
REQUEST = Struct("<BHB4x")
ANSWER = Struct("<BHB4s")
DOWNLOAD = Struct("<BHBI")
UPLOAD, FOUR_BYTES_DOWN, ABORTED = 0x40, 0x23, 0x80
WRITTEN = 0x60  # a drive's answer to a write
ANSWERED = 0.01  # s after which a node is taken to have answered: it serves one request at a time
SIZES = {0x4F: 1, 0x4B: 2, 0x47: 3, 0x43: 4, 0x42: 4}  # of an expedited answer, by its command
MODES, MODE_DISPLAY = 0x6060, 0x6061

Entry = tuple[int, int]  # index, sub-index
Question = tuple[int, int, int]  # axis, index, sub-index


def every(sdo_reserve: float, bitrate: int) -> float:
    """s between two questions, so that they fit into what the bus keeps free for SDO."""
    free = SHARE * sdo_reserve * bitrate
    return float(np.clip(QUESTION / free, QUICKEST, SLOWEST)) if free > 0 else SLOWEST


class Poll:
    """``temperatures``: (index, °C per count) for each axis that can tell, else None;
    ``modes``: which axes show their mode, and who is told what they show;
    ``on_refusal`` gets axis, index and abort code of a ``set`` that a drive does not take;
    ``on_change`` axis, index, sub-index, what was there and what is there of a ``fixed`` entry;
    ``on_taken`` axis and index of what a drive confirms that was written to it;
    ``period`` s between two questions."""

    def __init__(
        self,
        nodes: list[int],
        temperatures: list[tuple[int, float] | None],
        modes: list[bool],
        on_mode: Callable[[int, int], None],
        on_refusal: Callable[[int, int, int], None],
        on_change: Callable[[int, int, int, int, int], None],
        on_taken: Callable[[int, int], None],
        period: float = SLOWEST,
    ) -> None:
        self.values: NDArray[np.float64] = np.full(len(nodes), np.nan)
        self._nodes, self._temperatures = nodes, temperatures
        self._on_mode, self._on_refusal, self._on_change = on_mode, on_refusal, on_change
        self._on_taken = on_taken
        self._period = period
        self._to_set: list[dict[Entry, bytes]] = [{} for _ in nodes]  # frames, the last one first
        self._free = 0.0  # s, from when on another request may go out
        self._questions: list[Question] = [
            (k, known[0], 0) for k, known in enumerate(temperatures) if known
        ]
        self.measured = bool(self._questions)
        self._questions += [(k, MODE_DISPLAY, 0) for k, shown in enumerate(modes) if shown]
        self._shows_mode = modes
        self._fixed: list[dict[Entry, int]] = [{} for _ in nodes]
        self._fixed_questions: list[Question] = []
        self._suspected: deque[Question] = deque()  # somebody has written them
        self._turn, self._next_fixed, self._due = 0, 0, 0.0
        self._axis_of = {0x580 + node: k for k, node in enumerate(nodes)}

    def fix(self, axis: int, entries: Mapping[Entry, int]) -> None:
        """What this drive holds since it was set up, and shall go on to hold."""
        self._fixed[axis] = dict(entries)
        each = ([(k, *entry) for entry in held] for k, held in enumerate(self._fixed))
        rounds = zip_longest(*each)  # one drive after the other: each has time to answer
        self._fixed_questions = [one for many in rounds for one in many if one is not None]

    @property
    def round(self) -> float:
        """s in which every fixed entry is asked for once."""
        turns = len(self._fixed_questions)
        return self._period * turns * (1.0 + bool(self._questions) / FIXED_IN_A_ROW)

    def question(self, now: float) -> bytes:
        """The frames to send at ``now`` s, usually none."""
        if now < self._free:
            return b""
        if any(self._to_set):
            self._free = now + ANSWERED
            return self.settings()
        asked = self._suspected.popleft() if self._suspected else self._regular(now)
        if asked is None:
            return b""
        self._free = now + ANSWERED
        axis, index, sub = asked
        return frame(0x600 + self._nodes[axis], REQUEST.pack(UPLOAD, index, sub))

    def _regular(self, now: float) -> Question | None:
        if now < self._due or not (self._questions or self._fixed_questions):
            return None
        self._due = max(self._due, now - self._period) + self._period
        turn, self._turn = self._turn, self._turn + 1
        usual, fixed = self._questions, self._fixed_questions
        number, rest = divmod(turn, FIXED_IN_A_ROW + 1)
        if usual and (rest == 0 or not fixed):
            return usual[(number if fixed else turn) % len(usual)]
        self._next_fixed = (self._next_fixed + 1) % len(fixed)
        return fixed[self._next_fixed]

    def set(self, axis: int, index: int, sub: int, value: int, size: int = 4) -> None:
        """Write an object of so many bytes, before any question; the latest value counts."""
        data = DOWNLOAD.pack(FOUR_BYTES_DOWN | (4 - size) << 2, index, sub, value)
        self._to_set[axis].pop((index, sub), None)
        self._to_set[axis][index, sub] = frame(0x600 + self._nodes[axis], data)

    def settings(self) -> bytes:
        """What is to be sent now of what waits to be set: each drive serves one request a time."""
        return b"".join(waiting.popitem()[1] for waiting in self._to_set if waiting)

    def frame(self, can_id: int, data: bytes) -> None:
        """Take an answer, if this is one."""
        axis = self._axis_of.get(can_id)
        if axis is None or len(data) < ANSWER.size:
            return
        command, index, sub, four = ANSWER.unpack_from(data)
        if command == ABORTED and not self._asked(axis, index, sub):
            self._on_refusal(axis, index, int.from_bytes(four, "little"))
        if command == WRITTEN:
            self._on_taken(axis, index)
            self._suspect(axis, index, sub)
        if (size := SIZES.get(command)) is None:
            return
        if (was := self._fixed[axis].get((index, sub))) is not None:
            found, was = int.from_bytes(four[:size], "little"), was & (1 << 8 * size) - 1
            if found != was:
                self._on_change(axis, index, sub, was, found)
        elif sub:
            return
        elif index == MODE_DISPLAY:
            self._on_mode(axis, int.from_bytes(four[:size], "little", signed=True))
        elif (known := self._temperatures[axis]) is not None and index == known[0]:
            self.values[axis] = int.from_bytes(four[:size], "little", signed=True) * known[1]

    def _suspect(self, axis: int, index: int, sub: int) -> None:
        """A drive has taken what was written to it, and not by us: is asked for at once."""
        if index == MODES and self._shows_mode[axis]:
            index, sub = MODE_DISPLAY, 0
        elif (index, sub) not in self._fixed[axis]:
            return
        if (axis, index, sub) not in self._suspected:
            self._suspected.append((axis, index, sub))

    def _asked(self, axis: int, index: int, sub: int) -> bool:
        """Whether this is one of our questions, which a drive is free not to answer."""
        known = self._temperatures[axis]
        usual = (MODE_DISPLAY, known[0] if known else None)
        return index in usual or (index, sub) in self._fixed[axis]
