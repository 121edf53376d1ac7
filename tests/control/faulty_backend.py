"""A backend that breaks at any stage of its protocol, in any of the ways that code can."""

from __future__ import annotations

import errno
from typing import Any

import numpy as np
from fake_backend import FakeBackend, Flywheels

from backends.protocol import BackendFault, Feedback
from pa10d.common.errors import UserError

THROWN = {
    "a fault of one axis": lambda: BackendFault("lost its encoder", 1, "check its plug", "emcy"),
    "a fault of the bus": lambda: BackendFault("no bus", None, "check the cable", "bus_error"),
    "a fault of an axis that is none": lambda: BackendFault("lost", 9, "check", "emcy"),
    "a fault in numpy's numbers": lambda: BackendFault(
        ValueError("lost"),  # type: ignore[arg-type]
        np.int64(1),  # type: ignore[arg-type]
        "check",
    ),
    "a fault of an axis in words": lambda: BackendFault(
        "lost",
        "joint 2",  # type: ignore[arg-type]
        "check",
    ),
    "a fault of half an axis": lambda: BackendFault("lost", 0.5, "check"),  # type: ignore[arg-type]
    "a fault of very many words": lambda: BackendFault("lost: " + "ö\n" * 50_000, 1, "check"),
    "what the user can mend": lambda: UserError("cable.yaml: expected a port"),
    "an error of the code": lambda: TypeError("unsupported operand"),
    "an error of the system": lambda: OSError(errno.ENODEV, "No such device"),
    "an error without words": lambda: RuntimeError(),
    "no memory": lambda: MemoryError(),
    "the end of the process": lambda: SystemExit(3),
}


class FaultyBackend(FakeBackend):
    """``broken``: call -> what it throws from now on, every time; ``once``: the next time only."""

    def __init__(self, plant: Any = None, period: float = 0.002) -> None:
        self.broken: dict[str, Any] = {}
        self.once: dict[str, Any] = {}
        super().__init__(plant or Flywheels(2), period)
        self.reads: Any = None  # what ``read`` gives instead of its feedback

    def _enter(self, call: str) -> None:
        self.throw(call)
        super()._enter(call)

    def throw(self, call: str) -> None:
        if call in self.broken:
            raise self.broken[call]()
        if call in self.once:
            raise self.once.pop(call)()

    def close(self) -> None:
        self.throw("close")
        super().close()

    @property
    def switching(self) -> bool:
        self.throw("switching")
        return self._left > 0

    @property
    def warnings(self) -> list[str]:
        self.throw("warnings")
        return []

    @warnings.setter
    def warnings(self, _: list[str]) -> None: ...

    def read(self) -> Feedback:
        feedback = super().read()
        return feedback if self.reads is None else self.reads(feedback)
