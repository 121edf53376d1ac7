"""Reading and writing a drive's objects by SDO, with absence as an answer and not an exception."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import canopen
from canopen import SdoAbortedError, SdoCommunicationError
from canopen.objectdictionary import (
    INTEGER_TYPES,
    SIGNED_TYPES,
    VISIBLE_STRING,
    ODVariable,
)

from backends.canopen_cia402.objects import ABSENT, declared
from backends.canopen_cia402.standard import standard

T = TypeVar("T")

NO_ANSWER = "No SDO response received"  # as canopen says it
LATE_ANSWERS = 3  # to what was given up: as many as a request is tried, and one to an abort


class SetupError(Exception):
    """The drive cannot be used as it is; every reason is one line."""

    def __init__(self, reasons: list[str]) -> None:
        super().__init__("; ".join(reasons))
        self.reasons = reasons


@dataclass(frozen=True)
class Variable:
    """How one is read and written; ``promised`` and ``readable`` by its EDS."""

    size: int  # bytes
    signed: bool
    text: bool
    promised: bool = False
    readable: bool = False

    def encoded(self, value: int) -> bytes:
        """OverflowError where it does not fit."""
        return value.to_bytes(self.size, "little", signed=self.signed)

    def decoded(self, data: bytes) -> int | str | None:
        """What came, however long it is: the drive knows its sizes, a file may not."""
        if not data:  # a value the device never set
            return None
        if self.text:
            return data.rstrip(b"\0").decode("ascii", errors="ignore")
        return int.from_bytes(data, "little", signed=self.signed)


class Remote:
    """One node's dictionary, as the drive answers: what the standards define is asked for whether
    its EDS has it or not, for a drive obeys what it has and not what a file says of it."""

    def __init__(self, node: canopen.RemoteNode) -> None:
        self.node = node
        self._mute = False  # about what it has not: it says nothing instead of no

    def has(self, index: int, sub: int = 0) -> bool:
        """Whether the EDS or the drive knows the object."""
        return declared(self.node, index) or self.read(index, sub) is not None

    def read(self, index: int, sub: int = 0) -> int | None:
        """A number, or None where the drive knows no such object."""
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
            data = variable.encoded(value)
            _asked(lambda: self.node.sdo.download(index, sub, data))
        except OverflowError:
            return f"by its EDS it has {variable.size} bytes, {value} needs more"
        except SdoAbortedError as refusal:
            if refusal.code in ABSENT or not (
                variable.promised or self.read(index, sub) is not None
            ):
                return "absent"
            return f"refused: {refusal}"
        except SdoCommunicationError as error:
            self._not_answered(variable, index, sub, error)
            return "absent"
        kept = self.read(index, sub)
        if kept == value or (kept is None and not variable.readable):
            return None
        return f"the drive keeps {kept} instead of {value}"

    def ensure(self, index: int, value: int, sub: int = 0) -> str | None:
        """The value is there, written where need be. None: it is, or the drive has no such object;
        else what is there instead."""
        found = self.read(index, sub)
        if found == value:
            return None
        problem = self.write(index, value, sub)
        return None if problem in (None, "absent") else f"found {found}, {problem}"

    def _read(self, index: int, sub: int) -> int | str | None:
        variable = self._variable(index, sub)
        if variable is None:
            return None
        try:
            return variable.decoded(_asked(lambda: self.node.sdo.upload(index, sub)))
        except SdoAbortedError as refusal:
            if refusal.code in ABSENT or not variable.readable:
                return None
            raise SetupError([f"SDO 0x{index:04X}:{sub} refused: {refusal}"]) from refusal
        except SdoCommunicationError as error:
            self._not_answered(variable, index, sub, error)
            return None

    def _not_answered(
        self, variable: Variable, index: int, sub: int, error: SdoCommunicationError
    ) -> None:
        """SetupError, but where it was asked for what its EDS does not have: it is not asked for
        such things again, for each takes seconds."""
        if variable.promised or str(error) != NO_ANSWER:
            raise SetupError([f"no answer to SDO 0x{index:04X}:{sub}: {error}"]) from error
        self._mute = True

    def _variable(self, index: int, sub: int) -> Variable | None:
        """By the standards, in the size that the EDS gives it; else by the EDS alone."""
        told: ODVariable | None = self.node.object_dictionary.get_variable(index, sub)
        kind = standard(index, sub)
        if told is None and self._mute:
            return None
        if told is None:
            return Variable(_bytes(kind), _signed(kind), text=False) if kind is not None else None
        own = told.data_type
        kept = own if kind is None or own in INTEGER_TYPES else kind
        signed, text = _signed(own if kind is None else kind), kept == VISIBLE_STRING
        return Variable(_bytes(kept), signed, text, promised=True, readable=told.readable)


def _signed(kind: int) -> bool:
    return kind in SIGNED_TYPES


def _bytes(kind: int) -> int:
    return ODVariable.STRUCT_TYPES[kind].size if kind in ODVariable.STRUCT_TYPES else 1


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
