"""What CiA 301 lets a master write to the communication objects of a node, and when."""

from __future__ import annotations

from backends.virtual.drives.heartbeats import watched_node
from backends.virtual.drives.object_dictionary import (
    DUPLICATE,
    INVALID_VALUE,
    NOT_MAPPABLE,
    PDO_TOO_LONG,
    WRONG_STATE,
    LiveDictionary,
    SdoAbort,
    Value,
)
from backends.virtual.drives.pdo import CODES, EACH_SYNC, INVALID, MAPPINGS, RPDO, TPDO

EXTENDED, PRODUCE_SYNC = 1 << 29, 1 << 30
CAN_ID = 0x7FF
BEYOND = 0x1FFFF800  # bits of an identifier of 29 bits, which we have not
COB_ID, TRANSMISSION_TYPE, INHIBIT_TIME, SYNC_START = 1, 2, 3, 6  # sub-indices of a record
COUNTS = (0, *range(2, 241))  # of a SYNC counter: none, or where it begins anew
FROM_EVENTS = range(254, 256)
FROM_REQUESTS = range(252, 254)
RESTRICTED = (
    *range(0x000, 0x080),
    *range(0x101, 0x181),
    *range(0x581, 0x600),
    *range(0x601, 0x680),
    *range(0x6E0, 0x700),
    *range(0x701, 0x800),
)
"""Identifiers that no configurable object may have."""


def check_write(dictionary: LiveDictionary, key: int, value: Value) -> None:
    """SdoAbort where the standard forbids the value, or forbids it now."""
    index, sub = key >> 8, key & 0xFF
    if not isinstance(value, int):
        return
    if index == 0x1003:
        _require(value == 0)  # zero empties the history, nothing else can be written
    elif index == 0x1005:
        _require(not value & PRODUCE_SYNC)
        _require_identifier(value)
    elif index == 0x1014:
        _check_emergency(dictionary, value)
    elif index == 0x1019:
        _require(value in COUNTS)
        _require(not dictionary.number(0x1006), WRONG_STATE)
    elif index == 0x1016:
        _check_consumer(dictionary, sub, value)
    elif RPDO <= index < RPDO + MAPPINGS or TPDO <= index < TPDO + MAPPINGS:
        _check_communication(dictionary, index, sub, value)
    elif RPDO <= index - MAPPINGS < RPDO + MAPPINGS or TPDO <= index - MAPPINGS < TPDO + MAPPINGS:
        _check_mapping(dictionary, index, sub, value)


def _require(holds: bool, otherwise: int = INVALID_VALUE) -> None:
    if not holds:
        raise SdoAbort(otherwise)


def _require_identifier(value: int) -> None:
    """Eleven bits, and none that belongs to a service of fixed identifiers."""
    _require(not value & (EXTENDED | BEYOND) and value & CAN_ID not in RESTRICTED)


def _check_emergency(dictionary: LiveDictionary, value: int) -> None:
    """Where it may be written at all: not to another identifier while it is in use."""
    if value & INVALID:
        return
    _require_identifier(value)
    before = dictionary.number(0x1014)
    _require(bool(before & INVALID) or value & CAN_ID == before & CAN_ID, WRONG_STATE)


def _exists(dictionary: LiveDictionary, communication: int) -> bool:
    return not dictionary.number(communication, COB_ID, INVALID) & INVALID


def _check_consumer(dictionary: LiveDictionary, sub: int, value: int) -> None:
    """One heartbeat time for one node."""
    node, time = watched_node(value), value & 0xFFFF
    others = [dictionary.number(0x1016, k + 1) for k in range(dictionary.number(0x1016))]
    watched = [
        watched_node(other) for k, other in enumerate(others) if k + 1 != sub and other & 0xFFFF
    ]
    _require(not (node and time and node in watched), DUPLICATE)


def _check_communication(dictionary: LiveDictionary, index: int, sub: int, value: int) -> None:
    if sub == COB_ID:
        if not value & INVALID:
            _require_identifier(value)
            before = dictionary.number(index, COB_ID, INVALID)
            changed = (value ^ before) & (CAN_ID | EXTENDED)
            _require(not (_exists(dictionary, index) and changed), WRONG_STATE)
    elif sub == TRANSMISSION_TYPE:
        sent = index >= TPDO
        _require(value in EACH_SYNC or value in FROM_EVENTS or (sent and value in FROM_REQUESTS))
    elif sub in (INHIBIT_TIME, SYNC_START) and index >= TPDO:
        _require(sub == INHIBIT_TIME or value in EACH_SYNC)
        _require(not _exists(dictionary, index), WRONG_STATE)


def _check_mapping(dictionary: LiveDictionary, index: int, sub: int, value: int) -> None:
    """The standard's order: PDO off, count to zero, entries, count, PDO on."""
    _require(not _exists(dictionary, index - MAPPINGS), WRONG_STATE)
    sent = index >= TPDO + MAPPINGS
    if sub:
        _require(dictionary.number(index) == 0, WRONG_STATE)
        if value:
            _check_entry(dictionary, value, sent)
        return
    entries = [dictionary.number(index, k + 1) for k in range(value)]
    for entry in entries:
        _check_entry(dictionary, entry, sent)
    _require(sum(entry & 0xFF for entry in entries) <= 64, PDO_TOO_LONG)


def _check_entry(dictionary: LiveDictionary, entry: int, sent: bool) -> None:
    """A PDO that is sent carries what can be read, one that is received what can be written."""
    declared = dictionary.entry(entry >> 16, entry >> 8 & 0xFF)
    allowed = declared.sendable if sent else declared.receivable
    fits = declared.size in CODES and declared.size * 8 == entry & 0xFF
    _require(allowed and fits, NOT_MAPPABLE)
