"""Looks at the drives from outside, over the bus, while nobody else need be alive."""

from __future__ import annotations

import struct
import time
from collections.abc import Iterable

import can

STATUS, POSITION = 0x6041, 0x6064
ENABLED = 0x27


class Observer:
    """Asks drives by expedited SDO uploads."""

    def __init__(
        self, channel: str, nodes: Iterable[int] = range(1, 8), interface: str = "virtualbus"
    ) -> None:
        self._bus = can.Bus(interface=interface, channel=channel)
        self._nodes = tuple(nodes)

    def close(self) -> None:
        self._bus.shutdown()

    def read(self, node: int, index: int) -> int:
        """An object of at most four bytes; asked again where a drive is just being reset."""
        for _ in range(10):
            found = self._ask(node, index)
            if found is not None:
                return found
        raise AssertionError(f"node {node} does not answer")

    def _ask(self, node: int, index: int) -> int | None:
        while self._bus.recv(0) is not None:
            pass  # what was said while nobody listened
        ask = struct.pack("<BHB4x", 0x40, index, 0)
        self._bus.send(can.Message(arbitration_id=0x600 + node, data=ask, is_extended_id=False))
        until = time.monotonic() + 0.2
        while time.monotonic() < until:
            got = self._bus.recv(0.05)
            mine = got is not None and got.arbitration_id == 0x580 + node
            if mine and struct.unpack_from("<H", got.data, 1)[0] == index:
                size = 4 - (got.data[0] >> 2 & 3)
                return int.from_bytes(got.data[4 : 4 + size], "little", signed=index == POSITION)
        return None

    def positions(self) -> list[int]:
        """Encoder counts of every drive."""
        return [self.read(node, POSITION) for node in self._nodes]

    def powered(self) -> list[bool]:
        """Whether each drive is enabled (then its brake is open)."""
        return [self.read(node, STATUS) & 0x6F in (ENABLED, 0x07) for node in self._nodes]

    def wait_for_rest(self, within: float) -> float:
        """Seconds until no drive is powered and none moves; fails when that takes too long."""
        began = time.monotonic()
        while time.monotonic() - began < within:
            if not any(self.powered()):
                before = self.positions()
                time.sleep(0.1)
                if before == self.positions():
                    return time.monotonic() - began
            time.sleep(0.05)
        raise AssertionError(f"not at rest with brakes on within {within} s")
