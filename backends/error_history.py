"""What drives remember of their errors, newest first, in numbers and in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from backends.faults import describe_code
from pa10d.common.jsonable import JsonObject

REGISTER = {
    0x01: "generic error",
    0x02: "current",
    0x04: "voltage",
    0x08: "temperature",
    0x10: "communication",
    0x20: "device profile",
    0x40: "reserved",
    0x80: "of the maker's own",
}
"""Bits of 0x1001 (CiA 301): what is wrong now."""


@dataclass(frozen=True)
class DriveErrors:
    """One drive's memory; None where the drive has no such object.

    register: 0x1001, what is wrong now; code: 0x603F, 0 for none; history: 0x1003, the newest
    first, an error code in the lower 16 bits and the maker's own in the upper ones.
    """

    register: int | None = None
    code: int | None = None
    history: tuple[int, ...] | None = None
    problem: str = ""  # why it could not be asked or emptied

    def document(self) -> JsonObject:
        """For JSON, each code with its words."""
        bits = self.register or 0
        return {
            "register": self.register,
            "wrong_now": [words for bit, words in REGISTER.items() if bits & bit],
            "error": None if not self.code else _entry(self.code),
            "history": None if self.history is None else [_entry(one) for one in self.history],
            "problem": self.problem or None,
        }


def _entry(value: int) -> JsonObject:
    code = value & 0xFFFF
    return {"code": code, "words": describe_code(code), "of_the_maker": value >> 16}


@runtime_checkable
class KeepsErrors(Protocol):
    """A backend whose drives can be asked; called while the arm is unpowered, open or not."""

    def read_errors(self) -> list[DriveErrors]:
        """One for each axis; a drive that does not answer says so in ``problem``."""
        ...

    def clear_errors(self) -> list[DriveErrors]:
        """Empty every drive's history; what is there then. A fault is not acknowledged by that."""
        ...
