"""Error memory of a virtual drive: EMCY frames, 0x1001, 0x1003, 0x603F (CiA 301, 7.2.7)."""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct

from backends.virtual.drives.object_dictionary import LiveDictionary, key_of

EMCY = Struct("<HB5x")  # error code, error register
LOST_HEARTBEAT, LOST_SYNC, POSITION_LIMIT = 0x8130, 0x8700, 0x8612
SHORT_PDO, LONG_PDO, SYNC_LENGTH, LATE_PDO = 0x8210, 0x8220, 0x8240, 0x8250
HISTORY = 0x1003
GENERIC, MANUFACTURER = 0x01, 0x80  # bits of 0x1001
BIT_OF_CLASS = {0x2: 0x02, 0x3: 0x04, 0x4: 0x08}  # current, voltage, temperature
COMMUNICATION, DEVICE_PROFILE = 0x10, 0x20


def register_bits(code: int) -> int:
    """The bits of 0x1001 that an error sets."""
    if code >= 0xFF00:
        return GENERIC | MANUFACTURER
    if code >> 12 == 0x8:
        return GENERIC | (COMMUNICATION if code < 0x8300 else DEVICE_PROFILE)
    return GENERIC | BIT_OF_CLASS.get(code >> 12, 0)


class ErrorMemory:
    """``say`` sends the eight bytes of an EMCY."""

    def __init__(self, dictionary: LiveDictionary, say: Callable[[bytes], None]) -> None:
        self._dictionary, self._say = dictionary, say
        self._history: list[int] = []
        self._present: list[int] = []  # errors that are not over
        entries = dictionary.entries
        self._places = sum(key_of(HISTORY, k + 1) in entries for k in range(254))
        self.publish()

    def emergency(self, code: int) -> None:
        """Remember an error and tell everybody."""
        self._history = [code, *self._history][: self._places]
        self._present = [code, *(known for known in self._present if known != code)]
        self.publish()
        self._say(EMCY.pack(code, self._register))

    def over(self, *codes: int) -> None:
        """These errors are repaired, without ``codes`` all; the history stays."""
        left = [known for known in self._present if codes and known not in codes]
        if len(left) == len(self._present) and codes:
            return
        self._present = left
        self.publish()
        self._say(EMCY.pack(0, self._register))

    def empty(self) -> None:
        """A master wrote zero to the number of errors."""
        self._history.clear()
        self.publish()

    def restarted(self, completely: bool) -> None:
        """After power-on nothing happened yet; a reset of the communication leaves the history."""
        self._present.clear()
        if completely:
            self._history.clear()
        self.publish()

    def publish(self) -> None:
        """Into the dictionary, where a reset may have left other values."""
        dictionary, history = self._dictionary, self._history
        dictionary.set(0x603F, self._present[0] if self._present else 0)
        dictionary.set(0x1001, self._register)
        dictionary.set(HISTORY, len(history))
        for k in range(self._places):
            if k < len(history):
                dictionary.set(HISTORY, history[k], k + 1)
            else:
                dictionary.forget(HISTORY, k + 1)

    @property
    def _register(self) -> int:
        bits = 0
        for code in self._present:
            bits |= register_bits(code)
        return bits
