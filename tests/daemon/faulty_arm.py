"""A third-party backend in a daemon of its own: an arm that stands still, and breaks on request.

The file that FAULTY_ARM names says which call breaks, how, and after how many of them.
"""

from __future__ import annotations

import errno
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bus"))

from still_arm import StillArm

from backends.protocol import Array, BackendFault, Feedback
from pa10d.profile import Profile


def hang() -> None:
    time.sleep(3600)


def raised(error: BaseException) -> None:
    raise error


WAYS = {
    "axis": lambda: raised(BackendFault("lost its encoder", 1, "check its plug", "emcy")),
    "code": lambda: raised(TypeError("unsupported operand")),
    "system": lambda: raised(OSError(errno.ENODEV, "No such device")),
    "exit": lambda: raised(SystemExit(3)),
    "hang": hang,
}


class FaultyArm(StillArm):
    def __init__(self, profile: Profile) -> None:
        self._plan = Path(os.environ["FAULTY_ARM"])
        self._seen: dict[str, Any] = {}
        self._calls = 0
        self._meet("factory")
        super().__init__(profile)

    def _meet(self, call: str) -> None:
        try:
            plan = json.loads(self._plan.read_text())
        except (OSError, ValueError):
            return
        if plan != self._seen:
            self._seen, self._calls = plan, 0
        if plan.get("call") != call:
            return
        self._calls += 1
        if self._calls > plan.get("after", 0):
            if plan.get("once"):
                self._plan.unlink()
            WAYS[plan["way"]]()

    def open(self) -> None:
        self._meet("open")
        super().open()

    def begin_enable(self) -> None:
        self._meet("begin_enable")

    def begin_disable(self) -> None:
        self._meet("begin_disable")

    def begin_reset(self) -> None:
        self._meet("begin_reset")

    def read(self) -> Feedback:
        self._meet("read")
        return super().read()

    def write(self, torque: Array) -> None:
        self._meet("write")

    def close(self) -> None:
        self._meet("close")


def open_backend(profile: Profile) -> FaultyArm:
    return FaultyArm(profile)
