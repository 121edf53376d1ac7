"""What a model is worth to a controller: one motion under each control law, side by side."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.experiments.analysis import tracking_of
from pa10d.services.library import Library, open_library
from pa10d.store import StoredRun

Array = NDArray[np.float64]
Document = dict[str, Any]

WITH_MODEL = ("feed_forward", "computed_torque")
SAME = 1e-6  # rad (m) between two motions that are one


def laws_for(models: Sequence[str]) -> list[Document]:
    """``{controller, model}`` of every law to compare: PID alone, then each law with each model."""
    return [
        {"controller": "pid", "model": None},
        *({"controller": law, "model": model} for law in WITH_MODEL for model in models),
    ]


def tracking_table(data: str, laws: Sequence[Mapping[str, Any]], runs: Sequence[str]) -> Document:
    """The table of runs that were moved by these laws, in their order; see ``compared``."""
    library = open_library(data)
    infos = [library.runs.find(run) for run in runs]
    names = [None if law["model"] is None else _name(library, law["model"]) for law in laws]
    moved = [
        {"controller": law["controller"], "model": name, "run": info.name, "run_id": info.id}
        for law, name, info in zip(laws, names, infos, strict=True)
    ]
    return compared(moved, [library.runs.read(info) for info in infos])


def compared(moved: Sequence[Document], runs: Sequence[StoredRun]) -> Document:
    """``laws``: each with RMS and largest tracking error per joint (rad, m) and its share of PID's;
    ``worth``: what the last model leaves of the first one's error, law by law.

    UserError where the runs are not of one motion."""
    _refuse_other_motions(moved, runs)
    found = [tracking_of(run) for run in runs]
    pid = next(seen.rms for law, seen in zip(moved, found, strict=True) if law["model"] is None)
    laws = [
        {**law, "rms": seen.rms.tolist(), "max": seen.worst.tolist(),
         "of_pid": _share(seen.rms, pid)}
        for law, seen in zip(moved, found, strict=True)
    ]  # fmt: skip
    return {"joints": list(runs[0].joints), "laws": laws, "worth": _worth(laws)}


def as_csv(document: Mapping[str, Any]) -> str:
    """A row per law and joint."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["controller", "model", "joint", "rms", "max", "of_pid"])
    for law in document["laws"]:
        columns = zip(document["joints"], law["rms"], law["max"], law["of_pid"], strict=True)
        for joint, *values in columns:
            told = ["" if v is None else f"{v:.6g}" for v in values]
            writer.writerow([law["controller"], law["model"] or "", joint, *told])
    return out.getvalue()


def _worth(laws: Sequence[Document]) -> list[Document]:
    """Of the last model against the first, where there are two."""
    found = []
    for controller in WITH_MODEL:
        mine = [law for law in laws if law["controller"] == controller]
        if len(mine) < 2:
            continue
        first, last = mine[0], mine[-1]
        before, after = np.array(first["rms"]), np.array(last["rms"])
        j = int(np.argmax(before - after))
        found.append(
            {
                "controller": controller,
                "from": first["model"],
                "to": last["model"],
                "rms": _share(after, before),
                "joint": j + 1,
                "before": float(before[j]),
                "after": float(after[j]),
            }
        )
    return found


def _share(of: Array, whole: Array) -> list[float | None]:
    return [float(a / b) if b > 0 else None for a, b in zip(of, whole, strict=True)]


def _name(library: Library, model: str) -> str:
    return library.models.find(model).name


def _refuse_other_motions(moved: Sequence[Document], runs: Sequence[StoredRun]) -> None:
    first = runs[0].samples.commands
    for law, run in zip(moved, runs, strict=True):
        sent = run.samples.commands
        if first is None or sent is None:
            raise UserError(f"run {law['run']}: no commands in it; expected runs of this program")
        if sent.q.shape != first.q.shape or np.abs(sent.q - first.q).max() > SAME:
            raise UserError(
                f"run {law['run']}: another motion than {moved[0]['run']}: the servo alone could "
                "not have followed it as it stands; expected a slower or smaller motion"
            )
