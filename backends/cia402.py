"""CiA 402 in tables: states, controlwords, modes and option codes (IEC 61800-7-201)."""

from __future__ import annotations

from enum import IntEnum, StrEnum


class DriveState(StrEnum):
    """States of the drive's power state machine."""

    NOT_READY = "not ready to switch on"
    DISABLED = "switch on disabled"
    READY = "ready to switch on"
    SWITCHED_ON = "switched on"
    ENABLED = "operation enabled"
    QUICK_STOP = "quick stop active"
    REACTING = "fault reaction active"
    FAULT = "fault"


# state -> (mask, bits) of the statusword 0x6041
STATUS_BITS: dict[DriveState, tuple[int, int]] = {
    DriveState.NOT_READY: (0x4F, 0x00),
    DriveState.DISABLED: (0x4F, 0x40),
    DriveState.READY: (0x6F, 0x21),
    DriveState.SWITCHED_ON: (0x6F, 0x23),
    DriveState.ENABLED: (0x6F, 0x27),
    DriveState.QUICK_STOP: (0x6F, 0x07),
    DriveState.REACTING: (0x4F, 0x0F),
    DriveState.FAULT: (0x4F, 0x08),
}
STATUS_MASK = 0x6F
STATUS_VOLTAGE, STATUS_WARNING, STATUS_REMOTE = 0x0010, 0x0080, 0x0200
STATUS_LIMIT, STATUS_FOLLOWS = 0x0800, 0x1000  # internal limit; drive follows the cyclic value

_BY_BITS = {
    word: state
    for word in range(STATUS_MASK + 1)
    for state, (mask, bits) in STATUS_BITS.items()
    if word & mask == bits
}


def state_of(statusword: int) -> DriveState | None:
    """The state a statusword tells, or None where the standard knows no such word."""
    return _BY_BITS.get(statusword & STATUS_MASK)


def remarks(statusword: int) -> list[str]:
    """What a drive says beside its state, for people."""
    said = []
    if statusword & STATUS_WARNING:
        said.append(
            "its drive warns (bit 7 of the statusword): look at its temperature, supply and error "
            "history 0x1003 before it becomes a fault"
        )
    if statusword & STATUS_LIMIT and state_of(statusword) is DriveState.ENABLED:
        said.append(
            "its drive limits torque or speed by itself (bit 11 of the statusword): look at "
            "0x6072, 0x6080, 0x607D and its current limit"
        )
    return said


class Control(IntEnum):
    """Values of the controlword 0x6040."""

    DISABLE_VOLTAGE = 0x00
    QUICK_STOP = 0x02
    SHUTDOWN = 0x06
    SWITCH_ON = 0x07
    ENABLE = 0x0F
    FAULT_RESET = 0x80


# the controlword that leads one step nearer to ENABLED; None: wait
TOWARDS_ENABLED: dict[DriveState, Control | None] = {
    DriveState.NOT_READY: None,
    DriveState.DISABLED: Control.SHUTDOWN,
    DriveState.READY: Control.SWITCH_ON,
    DriveState.SWITCHED_ON: Control.ENABLE,
    DriveState.ENABLED: Control.ENABLE,
    DriveState.QUICK_STOP: Control.DISABLE_VOLTAGE,
    DriveState.REACTING: None,
    DriveState.FAULT: None,
}

# and one step nearer to DISABLED, with the brake applied while the drive still holds the load
TOWARDS_DISABLED: dict[DriveState, Control | None] = {
    DriveState.NOT_READY: None,
    DriveState.DISABLED: Control.DISABLE_VOLTAGE,
    DriveState.READY: Control.DISABLE_VOLTAGE,
    DriveState.SWITCHED_ON: Control.SHUTDOWN,
    DriveState.ENABLED: Control.SWITCH_ON,
    DriveState.QUICK_STOP: Control.DISABLE_VOLTAGE,
    DriveState.REACTING: None,
    DriveState.FAULT: None,
}

MODE_CST = 10
SUPPORTS_CST = 1 << 9  # bit of 0x6502

MODES = {
    1: "profile position",
    2: "velocity",
    3: "profile velocity",
    4: "profile torque",
    6: "homing",
    7: "interpolated position",
    8: "cyclic synchronous position",
    9: "cyclic synchronous velocity",
    10: "cyclic synchronous torque",
}


def supported_modes(bits: int) -> list[str]:
    """Names of the modes that 0x6502 tells."""
    return [name for mode, name in MODES.items() if bits >> (mode - 1) & 1]


class Reaction(IntEnum):
    """0x6007, what to do when communication is lost."""

    NONE = 0
    FAULT = 1
    DISABLE_VOLTAGE = 2
    QUICK_STOP = 3


class FaultReaction(IntEnum):
    """0x605E, how to come to rest on a fault."""

    DISABLE = 0
    SLOW_DOWN = 1
    QUICK_STOP = 2


class QuickStop(IntEnum):
    """0x605A, how a quick stop ends."""

    DISABLE = 0
    SLOW_DOWN = 1
    QUICK_STOP = 2
    STAY_SLOW_DOWN = 5
    STAY_QUICK_STOP = 6
