"""CAN logs of any kind that python-can reads: the drives' TPDOs of a profile, one sample per
SYNC."""

from __future__ import annotations

import itertools
from array import array
from collections.abc import Iterable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

import can
import numpy as np
from numpy.typing import NDArray

from backends.cia402 import DriveState, state_of
from backends.scaling import scaling_of
from pa10d.common.errors import UserError
from pa10d.measurement.counters import unwrapped
from pa10d.profile import Profile
from pa10d.readers.bag_columns import columns_of
from pa10d.readers.bag_rows import BagTopic
from pa10d.readers.candump import CandumpReader
from pa10d.readers.part import Parts, Undecided
from pa10d.readers.table import ForeignTable
from pa10d.readers.vector_asc import since_begin
from pa10d.store.channels import Array

SYNC, ANSWER = 0x80, 0x180
OBJECTS = {"position": "<i4", "torque": "<i2", "statusword": "<u2"}
"""0x6064, 0x6077 and 0x6041, as this program's own TPDO 1 has them."""
LAYOUTS = [np.dtype(list(order)) for order in itertools.permutations(OBJECTS.items())]
SIZE = LAYOUTS[0].itemsize
STATES = np.array([state_of(word) is not None for word in range(0x80)])
READY = STATES & [state_of(word) is not DriveState.NOT_READY for word in range(0x80)]
"""Without the one that a drive leaves by itself: 0 is what other numbers are, too."""
SHOWN = 0.99  # share of statuswords that show a state of CiA 402
SMOOTHER = 10.0  # times, by which one order's positions are less ragged than another's
FEWEST, SMALLEST = 10, 200  # frames of a joint, bytes
OFTEN = 1.5  # answers to a SYNC; beyond it they are sent on their own account
BACK = 0.05  # s by which frames of several buses may overtake each other
COUNTER = 2.0**32  # positions are counted in so many bits, and run over
BEGIN = 1_000_000_000  # ns before the first frame
READERS = {".csv": can.CSVReader, ".db": can.SqliteReader, "candump": CandumpReader}
"""Told by what is in them."""


class DriveFrames:
    """One drive's: stamps in s, and 8 bytes each."""

    def __init__(self) -> None:
        self.stamps, self.data = array("d"), bytearray()

    def __len__(self) -> int:
        return len(self.stamps)

    def times(self) -> Array:
        """(N,) s."""
        return np.frombuffer(self.stamps, dtype=np.float64)

    def rows(self, layout: np.dtype) -> NDArray[np.void]:
        """(N,) with the fields of OBJECTS."""
        return np.frombuffer(self.data, dtype=layout)


class Frames:
    """One bus: SYNCs, and per joint its drive's answers."""

    def __init__(self, joints: int) -> None:
        self.syncs = array("d")
        self.answers = [DriveFrames() for _ in range(joints)]

    @property
    def whole(self) -> bool:
        """Whether every drive speaks on it."""
        return all(len(found) >= FEWEST for found in self.answers)


def read_can_log(
    path: Path, profile: Profile, kind: str = "", channel: str | None = None
) -> ForeignTable:
    """Position and torque of every drive, as this program's own TPDO 1 has them. kind: .csv or .db,
    whatever the file is called; channel: which bus, of a log of several."""
    if not profile.drives:
        raise UserError(f"{path}: a CAN log needs a profile with 'drives', expected one per joint")
    if path.suffix.lower() == ".mf4":
        _refuse_without_mdf(path)
    try:
        if path.stat().st_size < SMALLEST:
            raise ValueError("it ends before its first frame")
        with since_begin(path) as named, READERS.get(kind, can.LogReader)(named) as log:
            buses = _buses(log, {ANSWER + d.node: j for j, d in enumerate(profile.drives)})
    except UserError as error:
        raise UserError(f"{path}: {error}") from error
    except Exception as error:  # whatever a damaged log makes of its reader
        said = (str(error).strip() or type(error).__name__).splitlines()[0][:160]
        raise UserError(f"{path}: cannot be read ({said}); expected a CAN log") from error
    frames, parts = _bus(path, buses, channel, len(profile.drives))
    for j, found in enumerate(frames.answers):
        if len(found) < FEWEST:
            raise UserError(
                f"{path}: joint {j + 1}: {len(found)} frames 0x{ANSWER + profile.drives[j].node:X} "
                f"of {SIZE} bytes; expected TPDO 1 with 0x6064, 0x6077 and 0x6041"
            )
    joints = [f"joint {j}" for j in range(1, len(profile.drives) + 1)]
    layout = _layout(path, frames)
    try:
        topic = _topic(frames, profile, joints, layout)
    except UserError as error:
        raise UserError(f"{path}: {error}") from error
    table = columns_of(path, {"the bus": topic}, joints)
    if layout != LAYOUTS[0]:
        order = ", ".join(layout.names or ())
        table.remarks.append(f"TPDO 1 holds {order} in this order, by what is in it")
    table.parts = parts
    return table


def _layout(path: Path, frames: Frames) -> np.dtype:
    """The order in which the drives map their objects: one in which the statuswords show states;
    this program's own, unless another one has much smoother positions."""
    shown = [layout for layout in LAYOUTS if _share_of_states(frames, layout) >= SHOWN]
    ragged = {layout: _raggedness(frames, layout) for layout in shown}
    best = sorted(shown, key=lambda layout: ragged[layout])
    if LAYOUTS[0] in shown and ragged[LAYOUTS[0]] <= SMOOTHER * ragged[best[0]]:
        return LAYOUTS[0]
    if not best or (len(best) > 1 and ragged[best[1]] < SMOOTHER * ragged[best[0]]):
        raise UserError(
            f"{path}: the last two bytes of the drives' answers are no statusword of CiA 402; "
            "expected TPDO 1 with 0x6064 (position), 0x6077 (torque) and 0x6041 (statusword)"
        )
    return best[0]


def _share_of_states(frames: Frames, layout: np.dtype) -> float:
    words = np.concatenate([found.rows(layout)["statusword"] for found in frames.answers])
    states = STATES if layout == LAYOUTS[0] else READY
    return float(states[words & 0x7F].mean())


def _raggedness(frames: Frames, layout: np.dtype) -> float:
    """Sum of the positions' usual steps, counts."""
    rows = [found.rows(layout)["position"].astype(np.float64) for found in frames.answers]
    return float(sum(np.mean(np.abs(np.diff(unwrapped(one, COUNTER)))) for one in rows))


def _buses(log: Iterable[can.Message], nodes: Mapping[int, int]) -> dict[str, Frames]:
    buses: dict[str, Frames] = {}
    latest = -np.inf
    for message in log:
        if message.is_extended_id or message.is_error_frame or message.is_remote_frame:
            continue  # CANopen's own have 11 bits; others may share the wire
        j = nodes.get(message.arbitration_id)
        if j is None and message.arbitration_id != SYNC:
            continue
        if message.timestamp < latest - BACK:
            raise UserError(
                f"a frame comes {latest - message.timestamp:.3g} s before the one ahead of it: a "
                "clock that was set back, or two logs in one; expected stamps that rise"
            )
        latest = max(latest, message.timestamp)
        bus = buses.setdefault(str(message.channel), Frames(len(nodes)))
        if j is None:
            bus.syncs.append(message.timestamp)
        elif message.dlc == SIZE and len(message.data) == SIZE:
            bus.answers[j].stamps.append(message.timestamp)
            bus.answers[j].data += message.data
    return buses


def _bus(
    path: Path, buses: Mapping[str, Frames], channel: str | None, joints: int
) -> tuple[Frames, Parts | None]:
    """The one that the drives speak on, and which there are where they speak on several."""
    whole = sorted(name for name, frames in buses.items() if frames.whole)
    options = {name: f"{name} · {len(buses[name].answers[0])} answers" for name in whole}
    parts = Parts("bus", options, channel or "") if len(whole) > 1 else None
    if channel is not None:
        if channel not in buses:
            there = ", ".join(sorted(buses)) or "none"
            raise UserError(f"{path}: no bus {channel}; found {there}")
        return buses[channel], parts
    if parts:
        raise Undecided(
            f"{path}: the drives speak on {len(whole)} buses, {', '.join(whole)}; expected one: "
            f"--topic {whole[0]}",
            parts,
        )
    if whole:
        return buses[whole[0]], None
    most = max(buses.values(), key=lambda one: sum(map(len, one.answers)), default=None)
    return most or Frames(joints), None


def _topic(frames: Frames, profile: Profile, joints: Sequence[str], layout: np.dtype) -> BagTopic:
    """Each answer at the SYNC that it answers, where there is one."""
    assert profile.drives is not None
    topic, syncs = BagTopic(), np.frombuffer(frames.syncs, dtype=np.float64)
    begin = min(found.stamps[0] for found in frames.answers)
    begin = min(begin, float(syncs[0])) if len(syncs) else begin
    for joint, found, drive in zip(joints, frames.answers, profile.drives, strict=True):
        scaling, rows, t = scaling_of(drive), found.rows(layout), found.times()
        if len(syncs) >= FEWEST and len(t) < OFTEN * len(syncs):
            asked = np.searchsorted(syncs, t, "right") - 1
            if (asked >= 0).sum() < FEWEST:
                raise UserError(
                    f"{joint}: {(asked >= 0).sum()} of {len(t)} answers come behind a SYNC; "
                    "expected a log that begins with the motion's first SYNC"
                )
            t, rows = syncs[asked[asked >= 0]], rows[asked >= 0]
        counts = unwrapped(rows["position"].astype(np.float64), COUNTER)
        q = scaling.sign * counts / scaling.counts_per_radian - scaling.zero_offset
        tau = scaling.sign * rows["torque"] * scaling.rated / 1000.0
        stamps = np.rint((t - begin) * 1e9).astype(np.int64) + BEGIN
        for stamp, angle, torque in zip(stamps.tolist(), q.tolist(), tau.tolist(), strict=True):
            topic.keep(
                {"position": ([joint], [angle]), "effort": ([joint], [torque])}, stamp, stamp
            )
    return topic


def _refuse_without_mdf(path: Path) -> None:
    if find_spec("asammdf") is None:
        raise UserError(
            f"{path}: a CAN log in MDF 4, which needs asammdf; expected pip install 'pa10d[mf4]', "
            "or the log as .blf, .asc or .log"
        )
