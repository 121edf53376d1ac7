"""What a model is worth to a controller: one motion under each control law, side by side."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.control.laws import WITH_MODEL, Law, ModelLaw
from pa10d.experiments.analysis import tracking_of
from pa10d.experiments.request import laws_for
from pa10d.services.documents import Track
from pa10d.services.library import open_library
from pa10d.store import StoredRun

Array = NDArray[np.float64]

SAME = 1e-6  # rad (m) between two motions that are one


@dataclass(frozen=True)
class Moved:
    """A run, and the law that moved it; model: its name; run_id: None where it is in no store."""

    controller: Law
    model: str | None
    run: str
    run_id: str


@dataclass(frozen=True)
class Followed(Moved):
    """How well. rms, max: tracking error per joint, rad (m); of_pid: the share of PID's RMS."""

    rms: list[float]
    max: list[float]
    of_pid: list[float | None]


@dataclass(frozen=True)
class Worth:
    """What the last model leaves of the first one's RMS, under one law. joint: from 1, the one that
    gains most; before, after: its RMS, rad (m)."""

    controller: ModelLaw
    first: str | None
    last: str | None
    rms: list[float | None]
    joint: int
    before: float
    after: float

    def document(self) -> JsonObject:
        """As JSON."""
        told = dict(vars(self))
        return {"controller": told.pop("controller"), "from": told.pop("first"),
                "to": told.pop("last"), **told}  # fmt: skip


@dataclass(frozen=True)
class TrackingErrors:
    """One motion under each law; worth: empty where there is one model."""

    joints: tuple[str, ...]
    laws: list[Followed]
    worth: list[Worth]

    def document(self) -> JsonObject:
        """As JSON."""
        return {
            "joints": list(self.joints),
            "laws": [asdict(law) for law in self.laws],
            "worth": [one.document() for one in self.worth],
        }


def tracking_table(data: str, models: Sequence[str], runs: Sequence[str]) -> JsonObject:
    """The table of runs that were moved by the laws for these models, in their order, as JSON."""
    library = open_library(data)
    infos = [library.runs.find(run) for run in runs]
    moved = [
        Moved(law.controller, law.model and library.models.find(law.model).name, info.name, info.id)
        for law, info in zip(laws_for(models), infos, strict=True)
    ]
    return compared(moved, [library.runs.read(info) for info in infos]).document()


def compared(moved: Sequence[Moved], runs: Sequence[StoredRun]) -> TrackingErrors:
    """Every law's tracking errors beside PID's, and what the last model is worth, law by law.

    UserError where the runs are not of one motion."""
    _refuse_other_motions(moved, runs)
    found = [tracking_of(run) for run in runs]
    pid = next(seen.rms for law, seen in zip(moved, found, strict=True) if law.model is None)
    laws = [
        Followed(**vars(law), rms=seen.rms.tolist(), max=seen.worst.tolist(),
                 of_pid=_share(seen.rms, pid))
        for law, seen in zip(moved, found, strict=True)
    ]  # fmt: skip
    return TrackingErrors(tuple(runs[0].joints), laws, _worth(laws))


def as_csv(found: Track) -> str:
    """A row per law and joint."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["controller", "model", "joint", "rms", "max", "of_pid"])
    for law in found.laws:
        columns = zip(found.joints, law.rms, law.max, law.of_pid, strict=True)
        for joint, *values in columns:
            told = ["" if v is None else f"{v:.6g}" for v in values]
            writer.writerow([law.controller, law.model or "", joint, *told])
    return out.getvalue()


def _worth(laws: Sequence[Followed]) -> list[Worth]:
    """Of the last model against the first, where there are two."""
    found = []
    for controller in WITH_MODEL:
        mine = [law for law in laws if law.controller == controller]
        if len(mine) < 2:
            continue
        first, last = mine[0], mine[-1]
        before, after = np.array(first.rms), np.array(last.rms)
        j = int(np.argmax(before - after))
        found.append(
            Worth(
                controller, first.model, last.model, _share(after, before), j + 1,
                float(before[j]), float(after[j]),
            )
        )  # fmt: skip
    return found


def _share(of: Array, whole: Array) -> list[float | None]:
    return [float(a / b) if b > 0 else None for a, b in zip(of, whole, strict=True)]


def _refuse_other_motions(moved: Sequence[Moved], runs: Sequence[StoredRun]) -> None:
    first = runs[0].samples.commands
    for law, run in zip(moved, runs, strict=True):
        sent = run.samples.commands
        if first is None or sent is None:
            raise UserError(f"run {law.run}: no commands in it; expected runs of this program")
        if sent.q.shape != first.q.shape or np.abs(sent.q - first.q).max() > SAME:
            raise UserError(
                f"run {law.run}: another motion than {moved[0].run}: the servo alone could "
                "not have followed it as it stands; expected a slower or smaller motion"
            )
