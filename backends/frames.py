"""The 16-byte ``struct can_frame`` of Linux, as bytes: id and flags, length, three pads, 8 data.

A *packet* is one frame or several, one after the other.
"""

from __future__ import annotations

from collections.abc import Iterator
from struct import Struct

FRAME = Struct("=IB3x8s")
SIZE = FRAME.size  # 16
EXTENDED, REMOTE, ERROR = 0x80000000, 0x40000000, 0x20000000

# linux/can/error.h: class in the id, detail in data[1]
ERROR_CONTROLLER, ERROR_BUS_OFF = 0x004, 0x040
RX_OVERFLOW = 0x01


def frame(can_id: int, data: bytes = b"") -> bytes:
    """One data frame (11-bit id unless EXTENDED is set in ``can_id``)."""
    return FRAME.pack(can_id, len(data), data)


def frames(packet: bytes) -> Iterator[tuple[int, bytes]]:
    """(id with flags, data) of every frame in a packet; an incomplete tail is left out."""
    for offset in range(0, len(packet) - SIZE + 1, SIZE):
        can_id, length, data = FRAME.unpack_from(packet, offset)
        yield can_id, data[: min(length, 8)]


def overflow_frame() -> bytes:
    """The error frame a controller raises when its receive queue was full."""
    return FRAME.pack(ERROR | ERROR_CONTROLLER, 8, bytes([0, RX_OVERFLOW, 0, 0, 0, 0, 0, 0]))


def describe_error(can_id: int, data: bytes) -> str:
    """An error frame in words."""
    if can_id & ERROR_BUS_OFF:
        return "the CAN controller is bus-off"
    if can_id & ERROR_CONTROLLER and len(data) > 1 and data[1] & RX_OVERFLOW:
        return "the receive queue was full and frames were lost"
    return f"CAN error frame, class 0x{can_id & 0x1FFFFFFF:X}, data {data.hex(' ')}"
