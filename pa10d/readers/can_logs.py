"""CAN logs of any kind that python-can reads: the drives' TPDOs of a profile, one sample per
SYNC."""

from __future__ import annotations

import struct
from importlib.util import find_spec
from pathlib import Path

import can
import numpy as np

from backends.scaling import scaling_of
from pa10d.common.errors import UserError
from pa10d.profile import Profile
from pa10d.readers.table import Table
from pa10d.store.channels import Array

SYNC, ANSWER = 0x80, 0x180
TPDO = struct.Struct("<ihH")  # 0x6064 position, 0x6077 torque, 0x6041 statusword
FEWEST, SMALLEST = 10, 200  # frames of a joint, bytes
READERS = {".csv": can.CSVReader, ".db": can.SqliteReader}  # told by what is in them


def read_can_log(path: Path, profile: Profile, kind: str = "") -> Table:
    """Position and torque of every drive, as this program's own TPDO 1 has them. kind: .csv or .db,
    whatever the file is called."""
    if not profile.drives:
        raise UserError(f"{path}: a CAN log needs a profile with 'drives', expected one per joint")
    nodes = {ANSWER + drive.node: j for j, drive in enumerate(profile.drives)}
    syncs: list[float] = []
    seen: list[list[tuple[float, int, int]]] = [[] for _ in profile.drives]
    if path.suffix.lower() == ".mf4":
        _refuse_without_mdf(path)
    try:
        if path.stat().st_size < SMALLEST:
            raise ValueError("it ends before its first frame")
        with READERS.get(kind, can.LogReader)(path) as log:
            for message in log:
                if message.is_extended_id or message.is_error_frame or message.is_remote_frame:
                    continue  # CANopen's own have 11 bits; others may share the wire
                if message.arbitration_id == SYNC:
                    syncs.append(message.timestamp)
                elif (j := nodes.get(message.arbitration_id)) is not None:
                    data = bytes(message.data)
                    if len(data) == TPDO.size:
                        position, torque, _ = TPDO.unpack(data)
                        seen[j].append((message.timestamp, position, torque))
    except Exception as error:  # whatever a damaged log makes of its reader
        said = (str(error).strip() or type(error).__name__).splitlines()[0][:160]
        raise UserError(f"{path}: cannot be read ({said}); expected a CAN log") from error
    for j, found in enumerate(seen):
        if len(found) < FEWEST:
            raise UserError(
                f"{path}: joint {j + 1}: {len(found)} frames 0x{ANSWER + profile.drives[j].node:X} "
                f"of {TPDO.size} bytes; expected TPDO 1 with 0x6064, 0x6077 and 0x6041"
            )
    return Table(_columns(np.array(syncs), [np.array(found) for found in seen], profile))


def _refuse_without_mdf(path: Path) -> None:
    if find_spec("asammdf") is None:
        raise UserError(
            f"{path}: a CAN log in MDF 4, which needs asammdf; expected pip install 'pa10d[mf4]', "
            "or the log as .blf, .asc or .log"
        )


def _columns(syncs: Array, seen: list[Array], profile: Profile) -> dict[str, Array]:
    t = syncs if len(syncs) >= FEWEST else seen[0][:, 0]
    first = max(found[0, 0] for found in seen)
    last = min(found[-1, 0] for found in seen)
    t = t[(t >= first - 1.0) & (t <= last)]
    out: dict[str, Array] = {"time": t - t[0]}
    assert profile.drives is not None
    for j, (found, drive) in enumerate(zip(seen, profile.drives, strict=True), 1):
        scaling = scaling_of(drive)
        answer = np.minimum(np.searchsorted(found[:, 0], t), len(found) - 1)
        counts, per_mille = found[answer, 1], found[answer, 2]
        out[f"q{j}"] = scaling.sign * counts / scaling.counts_per_radian - scaling.zero_offset
        out[f"tau{j}"] = scaling.sign * per_mille * scaling.rated / 1000.0
    return out
