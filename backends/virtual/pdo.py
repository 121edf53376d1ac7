"""Process data objects of a virtual drive: mapping kept by SDO, packing compiled from it."""

from __future__ import annotations

from struct import Struct

from backends.virtual.object_dictionary import (
    NOT_MAPPABLE,
    PDO_TOO_LONG,
    WRONG_STATE,
    LiveDictionary,
    SdoAbort,
    Value,
    key_of,
)

INVALID = 1 << 31
SYNC_TYPES = range(0, 241)  # transmission types that wait for SYNC
CODES = {1: "B", 2: "H", 4: "I", 8: "Q"}


class Pdo:
    """One PDO as its two dictionary records say at the moment of ``compile``."""

    def __init__(self, dictionary: LiveDictionary, communication: int, mapping: int) -> None:
        self.cob_id = dictionary.number(communication, 1, INVALID)
        self.enabled = not self.cob_id & INVALID
        self.cob_id &= 0x7FF
        self.type = dictionary.number(communication, 2, 255)
        entries = [dictionary.number(mapping, k + 1) for k in range(dictionary.number(mapping))]
        keys = [entry >> 8 for entry in entries]
        if any(key not in dictionary.entries for key in keys):  # a vendor's unusual default
            self.enabled, keys = False, []
        declared = [dictionary.entries[key] for key in keys]
        code = [CODES[e.size].lower() if e.signed else CODES[e.size] for e in declared]
        self._struct = Struct("<" + "".join(code))
        self._keys = keys
        self._values = dictionary.values
        self.size = self._struct.size
        self.waiting: bytes | None = None  # received, to be applied at the next SYNC
        self.sent = b""  # last data of an event-driven one
        self.syncs = 0  # since it was last sent

    @property
    def synchronous(self) -> bool:
        return self.type in SYNC_TYPES

    def apply(self, data: bytes) -> bool:
        """Write the received values; False where the frame is too short to be trusted."""
        if len(data) < self.size:
            return False
        self._values.update(zip(self._keys, self._struct.unpack_from(data), strict=True))
        return True

    def pack(self) -> bytes:
        """The frame's data from the present values."""
        values = self._values
        return self._struct.pack(*[values[key] for key in self._keys])


def compile_pdos(dictionary: LiveDictionary, communication: int, mapping: int) -> list[Pdo]:
    """The enabled PDOs of one direction (0x1400/0x1600 or 0x1800/0x1A00)."""
    numbers = [k for k in range(4) if key_of(communication + k, 1) in dictionary.entries]
    pdos = [Pdo(dictionary, communication + k, mapping + k) for k in numbers]
    return [pdo for pdo in pdos if pdo.enabled and pdo.size]


def check_mapping_write(dictionary: LiveDictionary, key: int, value: Value) -> None:
    """CiA 301's order: PDO off, count to zero, entries, count, PDO on. Else SdoAbort."""
    index, sub = key >> 8, key & 0xFF
    if not (0x1600 <= index < 0x1800 or 0x1A00 <= index < 0x1C00) or not isinstance(value, int):
        return
    communication = index - 0x200
    if not dictionary.number(communication, 1, INVALID) & INVALID:
        raise SdoAbort(WRONG_STATE)
    if sub:
        if dictionary.number(index):
            raise SdoAbort(WRONG_STATE)
        if value:
            _check_entry(dictionary, value)
        return
    entries = [dictionary.number(index, k + 1) for k in range(value)]
    for entry in entries:
        _check_entry(dictionary, entry)
    if sum(entry & 0xFF for entry in entries) > 64:
        raise SdoAbort(PDO_TOO_LONG)


def _check_entry(dictionary: LiveDictionary, entry: int) -> None:
    declared = dictionary.entry(entry >> 16, entry >> 8 & 0xFF)
    if not declared.mappable or declared.size not in CODES or declared.size * 8 != entry & 0xFF:
        raise SdoAbort(NOT_MAPPABLE)
