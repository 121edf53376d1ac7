"""The report of a stored model, with its runs, its errors and its versions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pa10d.common.errors import UserError
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass
from pa10d.model.parameters import parameter_list
from pa10d.services.library import Library
from pa10d.services.models import compare_runs, write_file
from pa10d.store import RunInfo

if TYPE_CHECKING:
    from pa10d.report.blocks import Section
    from pa10d.report.model_page import Dossier, RunFigures

Progress = Callable[[float, str], None]
FITTED, JUDGED, SEARCHED = "fit", "judge", "judge in the search"
BELOW = 0.9  # of half the rate: a low-pass of a slower run


def write_model_report(
    library: Library,
    model: str,
    path: Path,
    runs: Sequence[str] = (),
    first: Sequence[Section] = (),
    progress: Progress = lambda share, what: None,
) -> Path:
    """One HTML file. runs: to judge by; default: those that it was judged by when it was made."""
    from pa10d.report.model_page import model_page

    return write_file(path, model_page(dossier(library, model, runs, progress), first))


def dossier(
    library: Library,
    model: str,
    runs: Sequence[str] = (),
    progress: Progress = lambda share, what: None,
    searched: Sequence[str] = (),
) -> Dossier:
    """Everything that the report of a model shows. searched: runs that a search judged by, which
    stand in the list of runs as well."""
    from pa10d.report.model_page import Dossier

    info = library.models.find(model)
    loaded = library.models.load(info)
    fitted = _here(library, loaded.runs)
    judged = _here(library, runs or loaded.notes.judged_on or (), bool(runs))
    fresh = [run for run in judged if run.id not in {other.id for other in fitted}]
    compared = None
    if judged:
        compared = compare_runs(
            library, info.id, [run.id for run in judged], force=True, progress=progress
        )  # fmt: skip
    used = {run.id: (run, FITTED) for run in fitted}
    for run in judged:
        both = f"{FITTED} and {JUDGED}" if run.id in used else JUDGED
        used[run.id] = (run, both)
    for run in _here(library, searched):
        used.setdefault(run.id, (run, SEARCHED))
    figures = [_figures(library, run, use, loaded.cutoff) for run, use in used.values()]
    versions = [
        (one.name, one.change, one.created[:16].replace("T", " "), one.software)
        for one in library.models.history(info)
    ]
    return Dossier(
        loaded, parameter_list(loaded), figures, versions,
        None if compared is None else compared.comparison,
        () if compared is None else compared.staircase,
        "which no fit of this model has seen" if len(fresh) == len(judged)
        else "some of which it was fitted to",
    )  # fmt: skip


def _here(library: Library, names: Sequence[str], strict: bool = False) -> list[RunInfo]:
    """Those of the names that are in the store; strict: all, or UserError."""
    found = {}
    for name in names:
        try:
            run = library.runs.find(name)
        except UserError:
            if strict:
                raise
            continue
        found[run.id] = run
    return list(found.values())


def _figures(library: Library, run: RunInfo, use: str, cutoff: float) -> RunFigures:
    from pa10d.report.model_page import RunFigures

    recording: Recording = library.runs.recording(run)
    band = min(cutoff, BELOW * 0.5 * recording.rate)
    speed, acceleration = Lowpass(len(recording.q), recording.rate, band).derivatives(recording.q)[
        1:
    ]
    return RunFigures(
        run.name, run.id, use, run.kind, run.created[:16].replace("T", " "),
        len(recording.q) / recording.rate, recording.rate,
        recording.q.min(axis=0), recording.q.max(axis=0), np.abs(speed).max(axis=0),
        np.abs(acceleration).max(axis=0),
        np.abs(recording.tau).max(axis=0),
    )  # fmt: skip
