"""Models: identify, compare, show, trace back, take elsewhere."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.compare import Comparison, compare, document
from pa10d.dynamics.robot import Robot
from pa10d.figures.staircase import Stair
from pa10d.judgement import Judgement, judge
from pa10d.measurement.recording import Recording
from pa10d.model import Parameters, TorqueModel
from pa10d.model.notes import LeftOutNote
from pa10d.services.history import kin, line_band
from pa10d.services.library import Library
from pa10d.services.memory import refuse_beyond_memory
from pa10d.services.robots import load_robot
from pa10d.services.soundness import read_wrong, refuse_unsound
from pa10d.store import RunInfo
from pa10d.store.folders import write_text
from pa10d.store.models import ModelInfo
from pa10d.store.out_of_core import LARGE, RecordingOnDisk, size_in_memory
from pa10d.store.runs import in_order

if TYPE_CHECKING:
    from pa10d.export.endings import Format
    from pa10d.export.formats import Exported
    from pa10d.identify import FitOptions

JUDGED_BY = 2  # runs, for what an export loses
Progress = Callable[[float, str], None]
Stretch = tuple[str, float, float]
"""A run, and begin and end in s since its first sample."""


@dataclass(frozen=True)
class Identified:
    """A new model and what INTERFACES says of it."""

    info: ModelInfo
    model: TorqueModel
    summary: JsonObject


@dataclass(frozen=True)
class Compared:
    """A comparison of stored things; staircase: RMS per joint of the model and its ancestors on
    the same runs, the first ancestor first."""

    info: ModelInfo
    runs: tuple[RunInfo, ...]
    comparison: Comparison
    staircase: tuple[Stair, ...]

    def document(self) -> JsonObject:
        """As JSON."""
        found = document(self.comparison)
        for run, entry in zip(self.runs, found["runs"], strict=True):
            entry["id"] = run.id
        history = [
            {"model": step.name, "change": step.change, "rms": list(map(float, step.rms))}
            for step in self.staircase
        ]
        return {"id": self.info.id, "name": self.info.name, **found, "history": history}


def identify_runs(
    library: Library,
    runs: Sequence[str],
    profile: str | os.PathLike[str],
    *,
    name: str,
    options: FitOptions | None = None,
    left_out: Sequence[Stretch] = (),
    replace: bool = False,
    force: bool = False,
    progress: Progress | None = None,
    cancel: Callable[[], bool] | None = None,
) -> Identified:
    """Fit the textbook model to stored runs and store it; nothing is stored where that fails.

    left_out: what this fit does not use, beside what the runs themselves leave out; force: also to
    runs that the checks have an error against."""
    from pa10d.identify import summary

    if not replace:
        library.models.refuse_taken(name)
    robot = load_robot(profile)[1]
    infos, recordings = read_runs(library, runs, robot, force=force, out_of_core=True)
    for run, stretches in stretches_of(library, infos, left_out).items():
        recordings[run] = recordings[run].without(stretches)
    model, found = identified(
        recordings, robot, name=name, options=options, progress=progress, cancel=cancel
    )
    if left_out:
        without = tuple(
            LeftOutNote(library.runs.find(run).name, begin, end) for run, begin, end in left_out
        )
        model = dataclasses.replace(model, notes=dataclasses.replace(model.notes, left_out=without))
    if doubts := read_wrong(infos):
        told = dataclasses.replace(model.notes, warnings=(*doubts, *model.notes.warnings))
        model = dataclasses.replace(model, notes=told)
    info = library.models.save(model, replace=replace)
    return Identified(
        info, model, {**vars(summary(model)), **found.document(), "id": info.id, "name": info.name}
    )


def stretches_of(
    library: Library, infos: Sequence[RunInfo], left_out: Sequence[Stretch]
) -> dict[int, tuple[tuple[float, float], ...]]:
    """Place of a run -> all that is left out of it, for runs of which something more is."""
    ids = [info.id for info in infos]
    more: dict[int, list[tuple[float, float]]] = {}
    for name, begin, end in left_out:
        found = library.runs.find(name)
        if found.id not in ids:
            raise UserError(
                f"left out {begin:g} to {end:g} s of {found.name!r}: expected a stretch of one of "
                f"the runs that are fitted to, {', '.join(info.name for info in infos)}"
            )
        more.setdefault(ids.index(found.id), []).append((begin, end))
    return {k: in_order(infos[k], [*infos[k].excluded, *new]) for k, new in more.items()}


def identified(
    recordings: Sequence[Recording],
    robot: Robot,
    *,
    name: str,
    options: FitOptions | None = None,
    progress: Progress | None = None,
    cancel: Callable[[], bool] | None = None,
) -> tuple[TorqueModel, Judgement]:
    """The textbook model, see ``pa10d.identify.procedure``, and how it is judged on its own runs:
    that is what it says of itself."""
    from pa10d.identify import identify

    model = identify(
        recordings, robot, name=name, options=options, progress=progress, cancel=cancel
    )
    found = judge(model, recordings, model.cutoff)
    return with_noise_floor(dataclasses.replace(model, noise=found.rms), found), found


def compare_runs(
    library: Library,
    model: str,
    runs: Sequence[str],
    *,
    cutoff: float | None = None,
    force: bool = False,
    progress: Progress = lambda share, what: None,
) -> Compared:
    """Judge a stored model on stored runs, and all that it was made from.

    cutoff: Hz; default: the band that the model shares with its ancestors.
    """
    info = library.models.find(model)
    loaded = library.models.load(info)
    refuse_beyond_memory("compare", [library.runs.find(run) for run in runs])
    infos, recordings = read_runs(library, runs, loaded.robot, force=force)
    band = line_band(library, info.id) if cutoff is None else cutoff
    others = kin(library, [info])
    comparison = compare(loaded, recordings, progress, band, list(others.values()))
    comparison = dataclasses.replace(
        comparison, warnings=(*read_wrong(infos), *comparison.warnings)
    )
    errors = {info.id: comparison.pooled.scores.rms}
    for other, found in zip(others, comparison.beside, strict=True):
        errors |= {} if found is None else {other: found.rms}
    steps = [
        Stair(one.name, one.change, errors[one.id])
        for one in library.models.history(info)
        if one.id in errors
    ]
    return Compared(info, tuple(infos), comparison, tuple(steps))


def with_noise_floor(model: TorqueModel, found: Judgement) -> TorqueModel:
    """The model with the noise floor of a judgement among its notes, unless it has one."""
    if model.notes.noise_floor is not None or not np.all(np.isfinite(found.floor.values)):
        return model
    floor = tuple(map(float, found.floor.values))
    return dataclasses.replace(model, notes=dataclasses.replace(model.notes, noise_floor=floor))


def read_runs(
    library: Library,
    runs: Sequence[str],
    robot: Robot,
    *,
    force: bool = False,
    out_of_core: bool = False,
) -> tuple[list[RunInfo], list[Recording]]:
    """Stored runs of a robot by name or id; the same run given twice counts once.

    Unsound where the checks have an error against one of them, unless forced. out_of_core: for who
    works a stretch at a time and needs no further channels; together too large for memory, the
    recordings stay on disk."""
    infos = list({info.id: info for info in map(library.runs.find, runs)}.values())
    refuse_unsound(infos, force=force)  # what is known without reading
    large = sum(size_in_memory(info.samples, len(info.joints)) for info in infos) > LARGE
    recordings: list[Recording] = []
    for info in infos:
        recording = library.runs.recording(info)
        refuse_unsound([info], [recording], robot, force=force)
        on_disk = out_of_core and large
        recordings.append(RecordingOnDisk(recording, library.runs.folder) if on_disk else recording)
    return infos, recordings


def write_report(compared: Compared, path: Path) -> Path:
    """The comparison as one HTML file that opens offline."""
    from pa10d.report import compare_page

    return write_file(path, compare_page(compared.comparison, compared.staircase))


def export_model(
    library: Library, model: str, format: Format, parameters: Parameters = "feasible"
) -> tuple[ModelInfo, Exported]:
    """A stored model as text for other programs; what the format does not hold is told in N·m by
    runs that the model was judged by or fitted to, as far as they are in the store."""
    from pa10d.export.formats import export
    from pa10d.regression.equation import prepare

    info = library.models.find(model)
    loaded = library.models.load(info)
    about = f"{info.name} ({info.id}), {info.software}"
    names = _known_runs(library, (*loaded.held_out, *loaded.runs))[:JUDGED_BY]
    motions = {
        run.name: prepare(library.runs.recording(run), loaded.robot, loaded.cutoff).context
        for run in names
    }
    return info, export(loaded, format, parameters, about, motions)


def write_export(made: Exported, path: Path) -> None:
    """A file, or the folder where the format is one; UserError says what cannot be written."""
    if not made.files:
        write_file(path, made.text)
    for name, text in made.files.items():
        inside = path / name
        try:
            inside.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(
                f"{inside.parent}: {error.strerror}; expected a folder that can be written"
            ) from error
        write_file(inside, text)


def _known_runs(library: Library, names: Sequence[str]) -> list[RunInfo]:
    found = {}
    for name in names:
        try:
            run = library.runs.find(name)
        except UserError:
            continue
        found[run.id] = run
    return list(found.values())


def write_file(path: Path, text: str) -> Path:
    """Write it whole, or say why not."""
    try:
        write_text(path, text)
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}; expected a file that can be written") from error
    return path
