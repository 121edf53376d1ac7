"""The last seconds before a fault, as the daemon has kept them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.control.faults import Fault
from pa10d.control.record import SCALARS, VECTORS
from pa10d.store.entries import read_entry

Array = NDArray[np.float64]
LARGEST = 64 << 20  # bytes; five seconds of seven joints at 1 kHz are 3.2 MB


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
    """UserError where it cannot be read: it lies in the data folder, and may be anything."""
    try:
        with ZipFile(BytesIO(read_entry(path, LARGEST))) as packed:
            if sum(part.file_size for part in packed.infolist()) > LARGEST:
                raise ValueError(f"more than {LARGEST} bytes unpacked")
            found = {
                Path(part).stem: np.lib.format.read_array(
                    BytesIO(packed.read(part)), allow_pickle=False
                )
                for part in packed.namelist()
            }
        about = json.loads(str(found.pop("about")))
        fault, joints = Fault.from_document(about["fault"]), tuple(map(str, about["joints"]))
        fields = {name: _numbers(found, name, ()) for name in SCALARS}
        fields |= {name: _numbers(found, name, (len(joints),)) for name in VECTORS}
    except UserError:
        raise
    except Exception as error:  # of zip, zlib, numpy, json: nothing that a file holds is our bug
        raise UserError(f"{path}: not a file of a fault's last seconds ({error})") from error
    rows = {len(values) for values in fields.values()}
    if len(rows) != 1 or min(rows) < 2 or not np.isfinite(fields["time"]).all():
        raise UserError(f"{path}: expected two records or more, all fields as long, times finite")
    return FaultRecord(path.stem, fault, joints, fields)


def _numbers(found: dict[str, Array], name: str, shape: tuple[int, ...]) -> Array:
    """A field (N, *shape)."""
    values = found[name]
    if values.dtype.kind not in "fiub" or values.shape[1:] != shape or not values.ndim:
        raise ValueError(f"{name}: found {values.dtype} {values.shape}, expected (N, *{shape})")
    return values
