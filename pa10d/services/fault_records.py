"""The last seconds before a fault, as the daemon has kept them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.control.faults import Fault
from pa10d.control.record import SCALARS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class KeptFault:
    """The last seconds before a fault, kept."""

    id: str
    kind: str
    joint: int | None
    sentence: str
    seconds: float


@dataclass(frozen=True)
class FaultList:
    """Newest first."""

    items: list[KeptFault]


@dataclass(frozen=True)
class FaultRecord:
    """id: the file's; joints: their names; fields: of the loop's records, (N, ...) each."""

    id: str
    fault: Fault
    joints: tuple[str, ...]
    fields: dict[str, Array]

    @property
    def brief(self) -> KeptFault:
        """As it stands in a list."""
        time = self.fields["time"]
        return KeptFault(
            id=self.id,
            kind=self.fault.kind,
            joint=self.fault.joint,
            sentence=self.fault.sentence,
            seconds=float(time[-1] - time[0]),
        )


def read_fault(path: Path) -> FaultRecord:
    """UserError where it cannot be read."""
    try:
        with np.load(path, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            fields = {name: file[name] for name in file.files if name != "about"}
        fault, joints = Fault.from_document(about["fault"]), tuple(map(str, about["joints"]))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise UserError(f"{path}: not a file of a fault's last seconds ({error})") from error
    missing = [name for name in (*SCALARS, "q", "tau") if name not in fields]
    if missing or len(fields["time"]) < 2:
        raise UserError(f"{path}: found no {', '.join(missing) or 'two records'} in it")
    return FaultRecord(path.stem, fault, joints, fields)
