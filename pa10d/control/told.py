"""What control tells of the arm, whenever it changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pa10d.common.jsonable import JsonObject
from pa10d.control.brake_proof import Unheld
from pa10d.control.faults import Fault
from pa10d.control.whereabouts import Misplaced


@dataclass(frozen=True)
class ArmTold:
    """controller: the law in force; model: its name; warnings: the backend's; misplaced: joints
    that read elsewhere than they stood; unheld: joints whose brakes did not hold them as power was
    to go last, so that it stayed; doubted: joints, from 1, whose torque may act the wrong
    way round, by what was seen; sequence: of the record at which it was so; signals: how
    often this process was told to stop by one."""

    state: str = "offline"
    fault: Fault | None = None
    controller: str = "pid"
    model: str | None = None
    warnings: tuple[str, ...] = ()
    misplaced: tuple[Misplaced, ...] = ()
    unheld: tuple[Unheld, ...] = ()
    doubted: tuple[int, ...] = ()
    sequence: int = 0
    signals: int = 0

    def document(self) -> JsonObject:
        """The event."""
        fault = None if self.fault is None else self.fault.document()
        lists = {
            "warnings": list(self.warnings),
            "misplaced": [one.document() for one in self.misplaced],
            "unheld": [one.document() for one in self.unheld],
            "doubted": list(self.doubted),
        }
        return {"event": "state", **vars(self), "fault": fault, **lists}

    @staticmethod
    def from_document(event: Mapping[str, Any]) -> ArmTold:
        """The other way; KeyError or TypeError where it is none."""
        fault = event["fault"]
        return ArmTold(
            state=str(event["state"]),
            fault=None if fault is None else Fault.from_document(fault),
            controller=str(event["controller"]),
            model=event.get("model"),
            warnings=tuple(map(str, event["warnings"])),
            misplaced=tuple(map(Misplaced.from_document, event.get("misplaced", ()))),
            unheld=tuple(map(Unheld.from_document, event.get("unheld", ()))),
            doubted=tuple(map(int, event.get("doubted", ()))),
            sequence=int(event.get("sequence", 0)),
            signals=int(event.get("signals", 0)),
        )
