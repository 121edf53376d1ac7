"""Process data objects of a virtual drive: what their records say, compiled for the cycle."""

from __future__ import annotations

from math import inf
from struct import Struct

from backends.virtual.drives.object_dictionary import LiveDictionary, key_of

RPDO, TPDO, MAPPINGS = 0x1400, 0x1800, 0x200  # communication records; their mappings lie 0x200 on
INVALID, NO_REMOTE = 1 << 31, 1 << 30  # of a COB-ID
EACH_SYNC = range(0, 241)  # transmission types that wait for SYNC
ASKED_AT_SYNC, ASKED = 252, 253  # sent on a remote frame only: as it was at SYNC, as it is now
CODES = {1: "B", 2: "H", 4: "I", 8: "Q"}


class _Pdo:
    """The part of both directions: identifier, transmission type and mapping."""

    def __init__(self, dictionary: LiveDictionary, communication: int) -> None:
        number = dictionary.number
        mapping = communication + MAPPINGS
        cob_id = number(communication, 1, INVALID)
        self.enabled = not cob_id & INVALID
        self.cob_id, self.remote = cob_id & 0x7FF, not cob_id & NO_REMOTE
        self.type = number(communication, 2, 255)
        entries = [number(mapping, k + 1) for k in range(number(mapping))]
        keys = [entry >> 8 for entry in entries]
        if any(key not in dictionary.entries for key in keys):  # a vendor's unusual default
            self.enabled, keys = False, []
        declared = [dictionary.entries[key] for key in keys]
        code = [CODES[e.size].lower() if e.signed else CODES[e.size] for e in declared]
        self._struct = Struct("<" + "".join(code))
        self._values = dictionary.values
        self.keys = keys
        self.size = self._struct.size
        self.enabled = self.enabled and self.size > 0


class ReceivePdo(_Pdo):
    """One RPDO. ``waiting`` was received and takes effect with the next SYNC; ``late``: the next
    one is overdue by its event timer, which runs from the first one on."""

    def __init__(self, dictionary: LiveDictionary, communication: int) -> None:
        super().__init__(dictionary, communication)
        self.wrong_length = False  # the last frame's; told once
        self._deadline = dictionary.number(communication, 5) * 1e-3 or inf  # s
        self.forget()

    def forget(self) -> None:
        """As if none had been received."""
        self.waiting: bytes | None = None
        self.late, self._since = False, -inf

    @property
    def awaited(self) -> bool:
        """Whether it has a deadline."""
        return self._deadline < inf

    def came(self) -> None:
        """It was received."""
        self.late, self._since = False, 0.0

    def overdue(self, dt: float) -> bool:
        """Whether it has become late within these s."""
        self._since += dt
        self.late, before = self._since > self._deadline + 1e-9, self.late
        return self.late and not before

    @property
    def synchronous(self) -> bool:
        return self.type in EACH_SYNC

    def apply(self, data: bytes) -> None:
        """Write the received values; what is too long is not looked at."""
        self._values.update(zip(self.keys, self._struct.unpack_from(data), strict=True))


class TransmitPdo(_Pdo):
    """One TPDO, and when it is due."""

    def __init__(self, dictionary: LiveDictionary, communication: int) -> None:
        super().__init__(dictionary, communication)
        self._inhibit = dictionary.number(communication, 3) * 1e-4  # s
        self._longest = dictionary.number(communication, 5) * 1e-3 or inf  # s, the event timer
        self._start = dictionary.number(communication, 6)  # the SYNC that counts as the first one
        self.restart()

    def restart(self) -> None:
        """Nothing was sent yet."""
        self._sent: bytes | None = None
        self._sampled: bytes | None = None
        self._since, self._syncs = inf, 0  # s and SYNCs since it was last sent
        self._begun = not self._start

    @property
    def synchronous(self) -> bool:
        return self.type in EACH_SYNC

    def due(self, dt: float, synced: bool, count: int | None = None) -> bytes | None:
        """The data to send after ``dt`` s, at whose end a SYNC came or not; count: the SYNC's own,
        where it has one."""
        self._since += dt
        if self.type > ASKED:
            return self._at_event()
        return self._at_sync(count) if synced else None

    def asked(self) -> bytes | None:
        """The data to send on a remote frame."""
        if not self.remote:
            return None
        waits = self.type in EACH_SYNC or self.type == ASKED_AT_SYNC
        return self._sampled if waits and self._sampled is not None else self._pack()

    def _at_event(self) -> bytes | None:
        """A changed value is the event; no sooner than the inhibit time, and by the event timer."""
        if self._since < self._inhibit - 1e-9:
            return None
        data = self._pack()
        if data == self._sent and self._since < self._longest - 1e-9:
            return None
        return self._note(data)

    def _at_sync(self, count: int | None) -> bytes | None:
        self._begun = self._begun or count is None or count == self._start
        if not self._begun:
            return None
        self._syncs += 1
        if self.type in EACH_SYNC and self._syncs < self.type:
            return None
        data = self._sampled = self._pack()
        if self.type not in EACH_SYNC or (self.type == 0 and data == self._sent):
            return None
        return self._note(data)

    def _note(self, data: bytes) -> bytes:
        self._sent, self._since, self._syncs = data, 0.0, 0
        return data

    def _pack(self) -> bytes:
        values = self._values
        return self._struct.pack(*[values.get(key, 0) for key in self.keys])


def declared(dictionary: LiveDictionary, first: int) -> list[int]:
    """The communication records of a direction that this drive has."""
    records = range(first, first + MAPPINGS)
    return [record for record in records if key_of(record, 1) in dictionary.entries]
