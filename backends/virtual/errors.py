"""Error memory of a virtual drive: EMCY frames, 0x1001, 0x1003, 0x603F."""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct

from backends.virtual.object_dictionary import LiveDictionary

EMCY = Struct("<HB5x")  # error code, error register
LOST_HEARTBEAT, LOST_SYNC, SHORT_PDO, POSITION_LIMIT = 0x8130, 0x8700, 0x8210, 0x8612
GENERIC, COMMUNICATION = 0x01, 0x10  # bits of 0x1001


class ErrorMemory:
    """``say`` sends the eight bytes of an EMCY."""

    def __init__(self, dictionary: LiveDictionary, say: Callable[[bytes], None]) -> None:
        self._dictionary, self._say = dictionary, say
        self._history: list[int] = []

    def emergency(self, code: int) -> None:
        """Remember an error and tell everybody."""
        register = GENERIC | (COMMUNICATION if 0x8100 <= code < 0x8300 else 0)
        self._history = [code, *self._history][:8]
        self._dictionary.set(0x603F, code)
        self._dictionary.set(0x1001, register)
        self._dictionary.set(0x1003, len(self._history))
        for k, error in enumerate(self._history):
            self._dictionary.set(0x1003, error, k + 1)
        self._say(EMCY.pack(code, register))

    def cleared(self) -> None:
        """The fault was reset; the history stays."""
        self._dictionary.set(0x603F, 0)
        self._dictionary.set(0x1001, 0)
        self._say(EMCY.pack(0, 0))
