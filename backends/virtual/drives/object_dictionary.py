"""The object dictionary of a virtual drive: what its EDS declares, with values that live.

Values are kept under one integer key, ``index << 8 | sub-index``, so that the cycle finds them
without a detour; services (SDO) go through ``read`` and ``write``, which keep the EDS's rules.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from canopen.objectdictionary import ODVariable, datatypes

from backends.eds import load_eds

NOT_FOUND, NO_SUB_INDEX = 0x06020000, 0x06090011
READ_ONLY, WRITE_ONLY = 0x06010002, 0x06010001
TOO_LONG, TOO_SHORT, OTHER_LENGTH = 0x06070012, 0x06070013, 0x06070010
TOO_HIGH, TOO_LOW, INVALID_VALUE = 0x06090031, 0x06090032, 0x06090030
NOT_MAPPABLE, PDO_TOO_LONG, DUPLICATE = 0x06040041, 0x06040042, 0x06040043
NO_DATA, WRONG_STATE = 0x08000024, 0x08000022
BAD_COMMAND, BAD_TOGGLE = 0x05040001, 0x05030000

SIZES = {
    datatypes.BOOLEAN: 1,
    datatypes.INTEGER8: 1,
    datatypes.INTEGER16: 2,
    datatypes.INTEGER32: 4,
    datatypes.INTEGER64: 8,
    datatypes.UNSIGNED8: 1,
    datatypes.UNSIGNED16: 2,
    datatypes.UNSIGNED32: 4,
    datatypes.UNSIGNED64: 8,
}

Value = int | bytes


class SdoAbort(Exception):
    """An access that the dictionary refuses, with the SDO abort code."""

    def __init__(self, code: int) -> None:
        super().__init__(f"SDO abort 0x{code:08X}")
        self.code = code


@dataclass(frozen=True)
class Entry:
    """One variable as the EDS declares it; ``size`` in bytes, 0 for strings and domains."""

    name: str
    size: int
    signed: bool
    readable: bool
    writable: bool
    sendable: bool  # in a TPDO
    receivable: bool  # in an RPDO
    low: int | None
    high: int | None
    default: Value


def key_of(index: int, sub: int = 0) -> int:
    """The integer under which a value is kept."""
    return index << 8 | sub


class LiveDictionary:
    """Entries and values of one node. ``on_write(key, value)`` sees every accepted SDO write."""

    def __init__(self, eds: Path, node: int) -> None:
        self.entries = _entries(eds, node)
        self.values: dict[int, Value] = {}
        self.on_write: Callable[[int, Value], None] = lambda key, value: None
        self.may_write: Callable[[int, Value], None] = lambda key, value: None
        self._indices = {key >> 8 for key in self.entries}
        self.restore()

    def restore(self, communication_only: bool = False) -> None:
        """Power-on values; with ``communication_only`` those of 0x1000 … 0x1FFF."""
        for key, entry in self.entries.items():
            if not communication_only or key < 0x200000:
                self.values[key] = entry.default

    def number(self, index: int, sub: int = 0, default: int = 0) -> int:
        """A value as a number; ``default`` where the EDS declares no such object."""
        value = self.values.get(key_of(index, sub), default)
        return value if isinstance(value, int) else default

    def has(self, index: int, sub: int = 0) -> bool:
        """Whether the EDS declares such an object."""
        return key_of(index, sub) in self.entries

    def set(self, index: int, value: Value, sub: int = 0) -> None:
        """Change a value from inside the drive; ignored where the EDS declares no such object."""
        key = key_of(index, sub)
        if key in self.entries:
            self.values[key] = value

    def forget(self, index: int, sub: int) -> None:
        """From inside the drive: there is no value to be read."""
        self.values.pop(key_of(index, sub), None)

    def entry(self, index: int, sub: int) -> Entry:
        """The declaration, or SdoAbort."""
        found = self.entries.get(key_of(index, sub))
        if found is None:
            raise SdoAbort(NO_SUB_INDEX if index in self._indices else NOT_FOUND)
        return found

    def read(self, index: int, sub: int) -> bytes:
        """The bytes that an SDO upload gives."""
        entry = self.entry(index, sub)
        if not entry.readable:
            raise SdoAbort(WRITE_ONLY)
        value = self.values.get(key_of(index, sub))
        if value is None:
            raise SdoAbort(NO_DATA)
        if isinstance(value, bytes):
            return value
        return (value & (1 << 8 * entry.size) - 1).to_bytes(entry.size, "little")

    def write(self, index: int, sub: int, data: bytes) -> None:
        """What an SDO download does, with every check of type, access and range."""
        entry = self.entry(index, sub)
        if not entry.writable:
            raise SdoAbort(READ_ONLY)
        value: Value = data
        if entry.size:
            if len(data) != entry.size:
                raise SdoAbort(TOO_LONG if len(data) > entry.size else TOO_SHORT)
            value = int.from_bytes(data, "little", signed=entry.signed)
            if entry.high is not None and value > entry.high:
                raise SdoAbort(TOO_HIGH)
            if entry.low is not None and value < entry.low:
                raise SdoAbort(TOO_LOW)
        key = key_of(index, sub)
        self.may_write(key, value)
        self.values[key] = value
        self.on_write(key, value)


def _entries(eds: Path, node: int) -> dict[int, Entry]:
    entries = {}
    for item in load_eds(eds, node).values():
        for variable in [item] if isinstance(item, ODVariable) else item.values():
            entries[key_of(variable.index, variable.subindex)] = _entry(variable)
    return entries


def _entry(variable: ODVariable) -> Entry:
    size = SIZES.get(variable.data_type, 0)
    # a DCF's own value, except where the node number goes in: that file was made for one node
    given = variable.value if variable.value is not None and not variable.relative else None
    default = variable.default if given is None else given
    if size:
        value: Value = default if isinstance(default, int) else 0
    else:
        value = default.encode("latin-1") if isinstance(default, str) else b""
    mappable, access = bool(variable.pdo_mappable), variable.access_type
    return Entry(
        name=variable.name,
        size=size,
        signed=variable.data_type in datatypes.SIGNED_TYPES,
        readable=variable.readable,
        writable=variable.writable,
        sendable=mappable and access in ("ro", "const", "rw", "rwr"),
        receivable=mappable and access in ("wo", "rw", "rww"),
        low=variable.min if isinstance(variable.min, int) else None,
        high=variable.max if isinstance(variable.max, int) else None,
        default=value,
    )
