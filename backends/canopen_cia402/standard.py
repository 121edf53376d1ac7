"""Objects that CiA 301 and 402 define, with their types: a drive may have them, and obey them,
whatever its EDS says, be this older than the drive, cut short by its maker, or another drive's.
"""

from __future__ import annotations

from collections.abc import Collection

from canopen.objectdictionary import (
    INTEGER8,
    INTEGER16,
    INTEGER32,
    UNSIGNED8,
    UNSIGNED16,
    UNSIGNED32,
)

ALONE, PAIR = (0,), (1, 2)
TYPES: dict[int, tuple[Collection[int], int]] = {  # index -> sub-indices, their type
    0x1000: (ALONE, UNSIGNED32),
    0x1005: (ALONE, UNSIGNED32),
    0x1006: (ALONE, UNSIGNED32),
    0x1007: (ALONE, UNSIGNED32),
    0x100C: (ALONE, UNSIGNED16),
    0x100D: (ALONE, UNSIGNED8),
    0x1014: (ALONE, UNSIGNED32),
    0x1016: (range(1, 128), UNSIGNED32),
    0x1017: (ALONE, UNSIGNED16),
    0x1018: ((1, 2, 3, 4), UNSIGNED32),
    0x1019: (ALONE, UNSIGNED8),
    0x1029: ((1,), UNSIGNED8),
    0x6007: (ALONE, INTEGER16),
    0x603F: (ALONE, UNSIGNED16),
    0x605A: (ALONE, INTEGER16),
    0x605C: (ALONE, INTEGER16),
    0x605E: (ALONE, INTEGER16),
    0x6061: (ALONE, INTEGER8),
    0x6072: (ALONE, UNSIGNED16),
    0x6076: (ALONE, UNSIGNED32),
    0x607B: (PAIR, INTEGER32),
    0x607D: (PAIR, INTEGER32),
    0x607E: (ALONE, UNSIGNED8),
    0x6080: (ALONE, UNSIGNED32),
    0x6085: (ALONE, UNSIGNED32),
    0x608F: (PAIR, UNSIGNED32),
    0x6091: (PAIR, UNSIGNED32),
    0x6092: (PAIR, UNSIGNED32),
    0x60B0: (ALONE, INTEGER32),
    0x60B1: (ALONE, INTEGER32),
    0x60B2: (ALONE, INTEGER16),
    0x60E0: (ALONE, UNSIGNED16),
    0x60E1: (ALONE, UNSIGNED16),
    0x60FE: (PAIR, UNSIGNED32),
    0x6502: (ALONE, UNSIGNED32),
}
ONE_BYTE = {(0x1016, 0): UNSIGNED8, (0x60C2, 1): UNSIGNED8, (0x60C2, 2): INTEGER8}
PDOS = (0x1400, 0x1800)  # communication of as many as 512 each


def standard(index: int, sub: int) -> int | None:
    """The type of that variable, None: the standards have none there that is used here."""
    if index & 0xFE00 in PDOS and sub == 1:
        return UNSIGNED32
    subs, kind = TYPES.get(index, ((), None))
    return kind if sub in subs else ONE_BYTE.get((index, sub))
