"""One run being recorded: from the first marked record to the end of its motion."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.control.record import RecordLayout
from pa10d.store import RunInfo
from pa10d.store.channels import Channels, CommandedMotion, Samples
from pa10d.store.run_info import Status
from pa10d.store.run_writer import RunWriter

Array = NDArray[np.float64]


@dataclass
class Ending:
    """How the motion of a run ended."""

    status: Status
    reason: str = ""


class Session:
    """Takes all records in order and keeps those of its own motion."""

    def __init__(self, writer: RunWriter, layout: RecordLayout, motion: int, rows: int) -> None:
        """rows: how many records the whole motion has."""
        self.writer, self.motion = writer, motion
        self._layout, self._rows = layout, rows
        self._channels = writer.channels
        self._origin: tuple[float, int] | None = None  # s on the loop's clock, ns on the wall
        self._lost = 0

    @property
    def started(self) -> bool:
        """Whether a sample was taken."""
        return self._origin is not None

    def take(self, rows: Array, lost: int) -> Ending | None:
        """Keep what belongs here → how the motion ended, once it has."""
        get = self._layout.get
        mine = (get(rows, "motion") == self.motion) & (get(rows, "recording") > 0)
        kept = rows[mine]
        if self.started or len(kept):
            self._lost += lost
        if len(kept):
            self.writer.append(self._samples(kept))
        if len(kept) and int(get(kept, "row")[-1]) >= self._rows:
            return Ending("success")
        after = rows[np.argmax(mine) :] if len(kept) else rows
        left = after[get(after, "motion") != self.motion]
        if not self.started or not len(left):
            return None
        faulty = get(left, "fault")[0] > 0
        return (
            Ending("aborted", "a fault") if faulty else Ending("stopped", "stopped before its end")
        )

    def close(self, ending: Ending) -> RunInfo:
        """Finish the run."""
        warnings = self.writer.info.warnings
        if self._lost:
            lost = f"{self._lost} samples were overwritten before they could be written"
            warnings = (*warnings, lost)
        return self.writer.close(ending.status, ending.reason, warnings=warnings)

    def salvage(self, error: OSError) -> RunInfo:
        """The disk takes no more: the run ends with what it took."""
        said = f"{error.strerror} while recording; what was written until then is kept"
        return self.writer.salvage(f"the run could not be written on: {said}")

    def _samples(self, rows: Array) -> Samples:
        get = self._layout.get
        t = get(rows, "time")
        if self._origin is None:
            self._origin = (float(t[0]), time.time_ns())
        start, wall = self._origin
        stamps = wall + np.rint((t - start) * 1e9).astype(np.int64)
        return Samples(
            stamps=stamps,
            q=get(rows, "q"),
            tau=get(rows, "tau"),
            commands=CommandedMotion(get(rows, "q_ref"), get(rows, "dq_ref"), get(rows, "torque")),
            temperature=get(rows, "temperature") if self._channels.temperature else None,
        )


def channels_of(joints: tuple[str, ...], layout: RecordLayout, last: Array | None) -> Channels:
    """Position, torque, commands; temperature where the drives have told one."""
    warm = last is not None and bool(np.isfinite(layout.get(last, "temperature")).any())
    return Channels(joints=joints, commands=True, temperature=warm)
