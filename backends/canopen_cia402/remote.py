"""Reading and writing a drive's objects by SDO, with absence as an answer and not an exception."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import canopen
from canopen import SdoAbortedError, SdoCommunicationError
from canopen.objectdictionary import ODVariable

from backends.canopen_cia402.objects import ABSENT

T = TypeVar("T")

NO_ANSWER = "No SDO response received"  # as canopen says it
LATE_ANSWERS = 3  # to what was given up: as many as a request is tried, and one to an abort


class SetupError(Exception):
    """The drive cannot be used as it is; every reason is one line."""

    def __init__(self, reasons: list[str]) -> None:
        super().__init__("; ".join(reasons))
        self.reasons = reasons


class Remote:
    """One node's dictionary, as its EDS declares it and the drive answers."""

    def __init__(self, node: canopen.RemoteNode) -> None:
        self.node = node

    def read(self, index: int, sub: int = 0) -> int | None:
        """A number, or None where EDS or drive know no such object."""
        value = self._read(index, sub)
        return value if isinstance(value, int) else None

    def text(self, index: int) -> str:
        """A string, empty where there is none."""
        value = self._read(index, 0)
        return value if isinstance(value, str) else ""

    def write(self, index: int, value: int, sub: int = 0) -> str | None:
        """Write and read back. None: done; else why not, in words ("absent" if it is)."""
        variable = self._variable(index, sub)
        if variable is None:
            return "absent"
        try:
            _asked(lambda: self.node.sdo.download(index, sub, variable.encode_raw(value)))
        except SdoAbortedError as refusal:
            return "absent" if refusal.code in ABSENT else f"refused: {refusal}"
        except SdoCommunicationError as error:
            raise SetupError([f"no answer to SDO 0x{index:04X}:{sub}: {error}"]) from error
        if not variable.readable:
            return None
        kept = self.read(index, sub)
        return None if kept == value else f"the drive keeps {kept} instead of {value}"

    def ensure(self, index: int, value: int, sub: int = 0) -> str | None:
        """The value is there, written where need be. None: it is, or the drive has no such object;
        else what is there instead."""
        found = self.read(index, sub)
        if found == value:
            return None
        problem = self.write(index, value, sub)
        return None if problem in (None, "absent") else f"found {found}, {problem}"

    def _read(self, index: int, sub: int) -> int | str | bytes | float | None:
        variable = self._variable(index, sub)
        if variable is None or not variable.readable:
            return None
        try:
            data = _asked(lambda: self.node.sdo.upload(index, sub))
        except SdoAbortedError as refusal:
            if refusal.code in ABSENT:
                return None
            raise SetupError([f"SDO 0x{index:04X}:{sub} refused: {refusal}"]) from refusal
        except SdoCommunicationError as error:
            raise SetupError([f"no answer to SDO 0x{index:04X}:{sub}: {error}"]) from error
        if len(data) < len(variable) // 8:  # a value the device never set
            return None
        return variable.decode_raw(data)

    def _variable(self, index: int, sub: int) -> ODVariable | None:
        return self.node.object_dictionary.get_variable(index, sub)


def _asked(ask: Callable[[], T]) -> T:
    """Once more where an answer came that is of no use: a request that was given up may be answered
    yet, and that answer is taken for the next one's. Who does not answer was asked often enough."""
    for _ in range(LATE_ANSWERS):
        try:
            return ask()
        except SdoCommunicationError as error:
            if str(error) == NO_ANSWER:
                raise
    return ask()
