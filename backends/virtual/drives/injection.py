"""Faults on purpose: what object 0x2F00 of a virtual drive makes happen (docs/faults.md)."""

from __future__ import annotations

from enum import IntEnum


class Injection(IntEnum):
    """Values of 0x2F00:1; 0x2F00:2 holds the argument, written first."""

    NONE = 0
    POWER_LOST = 1  # the node is gone, its brake falls in
    UNPLUGGED = 2  # the bus cable is off, the drive lives on
    REBOOT = 3  # as after a brown-out
    TPDO_LATE = 4  # the next [argument] TPDOs come a cycle late
    TPDO_TWICE = 5  # the next [argument] TPDOs come twice
    TPDO_SHORT = 6  # the next [argument] TPDOs lack their last two bytes
    TPDO_MUTE = 7  # the next [argument] TPDOs do not come
    EMCY = 8  # an EMCY with code [argument], the drive goes on
    FAULT = 9  # a fault with EMCY code [argument]
    FAULT_BIT = 10  # a fault that only the statusword tells
    HEARTBEAT_MUTE = 11  # no heartbeat any more
    ENCODER_JUMP = 12  # the encoder reads [argument] counts more
    WARNING = 13  # the warning bit of the statusword


class Injector:
    """Keeps what was asked for until it is used up."""

    def __init__(self) -> None:
        self.silent = False  # neither hears nor speaks
        self.heartbeat_mute = False
        self.warning = False
        self.counts = 0  # added to the encoder
        self._tpdo = Injection.NONE
        self._left = 0

    @property
    def idle(self) -> bool:
        """Whether the next TPDO goes out as it is."""
        return self._left <= 0

    def tpdo_fault(self) -> Injection:
        """What is to happen to the TPDO that is about to be sent."""
        if self.idle:
            return Injection.NONE
        self._left -= 1
        return self._tpdo

    def take(self, kind: Injection, argument: int) -> None:
        """Start one of the faults that only concern what is seen on the bus or the encoder."""
        match kind:
            case Injection.UNPLUGGED | Injection.POWER_LOST:
                self.silent = True
            case (
                Injection.TPDO_LATE
                | Injection.TPDO_TWICE
                | Injection.TPDO_SHORT
                | Injection.TPDO_MUTE
            ):
                self._tpdo, self._left = kind, max(argument, 1)
            case Injection.HEARTBEAT_MUTE:
                self.heartbeat_mute = True
            case Injection.ENCODER_JUMP:
                self.counts += argument
            case Injection.WARNING:
                self.warning = True
