"""What workers compute for the daemon: services, behind a border of JSON.

Arguments come as JSON knows them and results leave so: they pass to clients as they stand, as
``services/documents.py`` describes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pa10d.common.errors import Taken, Unsound, UserError
from pa10d.common.jsonable import JsonObject

Progress = Callable[[float, str], None]

if TYPE_CHECKING:
    from pa10d.export.endings import Format
    from pa10d.model import Parameters
    from pa10d.services.weighing.told import WeighingStatus


def import_file(
    data: str,
    file: str,
    profile: str,
    name: str | None,
    mapping: list[str],
    replace: bool,
    check: bool = False,
    force: bool = False,
    part: Mapping[str, Any] | None = None,
) -> JsonObject:
    """A recording into the store → its description, and what became of the mapping."""
    from pa10d.readers import Part
    from pa10d.services.robots import load_robot
    from pa10d.services.runs import import_run
    from pa10d.store import RunStore

    found, robot = load_robot(profile)
    try:
        result = import_run(
            RunStore(data), Path(file), found, robot, name=name, mapping=mapping, replace=replace,
            check=check, force=force, part=Part(**part or {}),
        )  # fmt: skip
    except (Taken, Unsound):
        raise
    except UserError as error:  # where the upload lies for a moment is nobody's business
        raise UserError(str(error).replace(f"{Path(file).parent}/", "")) from error
    return {"run": result.info.document(), "kept": result.kept}


def episodes_of_file(data: str, file: str) -> list[int]:
    """Numbers of the episodes of a data set's file."""
    from pa10d.readers import episodes_of

    try:
        return sorted(episodes_of(Path(file)))
    except UserError as error:
        raise UserError(str(error).replace(f"{Path(file).parent}/", "")) from error


def preview_file(
    data: str,
    file: str,
    profile: str,
    choices: list[dict[str, str]] | None,
    thorough: bool,
    part: Mapping[str, Any],
) -> JsonObject:
    """A file before it is imported → what ``pa10d run preview --json`` says."""
    from pa10d.readers import Part
    from pa10d.services.import_preview import preview_recording
    from pa10d.services.robots import load_robot
    from pa10d.store.column_choices import Choice

    found, robot = load_robot(profile)
    chosen = None if choices is None else [Choice(**one) for one in choices]
    try:
        return preview_recording(
            Path(file), found, robot, chosen, thorough=thorough, part=Part(**part)
        ).document()
    except UserError as error:
        raise UserError(str(error).replace(f"{Path(file).parent}/", "")) from error


def check_stored(data: str, run: str, profile: str) -> list[JsonObject]:
    """What ``pa10d run check --json`` says of a run."""
    from pa10d.services.robots import load_robot
    from pa10d.services.runs import check_run
    from pa10d.store import RunStore

    found, robot = load_robot(profile)
    return [one.document() for one in check_run(RunStore(data), run, robot, found)]


def export_file(data: str, run: str, format: str, file: str) -> None:
    """A run as a file."""
    from pa10d.store import RunStore
    from pa10d.store.export import export_run

    store = RunStore(data)
    export_run(store, store.find(run), format, Path(file), replace=False)


def identify(
    data: str,
    runs: list[str],
    profile: str,
    name: str,
    progress: Progress,
    replace: bool = False,
    force: bool = False,
    left_out: Sequence[Mapping[str, Any]] = (),
    **how: Any,
) -> JsonObject:
    """The textbook model → what ``pa10d identify --json`` says. how: see ``FitOptions.read``."""
    from pa10d.identify import FitOptions
    from pa10d.services.library import open_library
    from pa10d.services.models import identify_runs

    return identify_runs(
        open_library(data), runs, profile, name=name, options=FitOptions.read(how),
        replace=replace, force=force,
        left_out=[(one["run"], one["begin"], one["end"]) for one in left_out],
        progress=progress,
    ).summary  # fmt: skip


def compare(
    data: str,
    model: str,
    runs: list[str],
    progress: Progress,
    sheet: str | None = None,
    cutoff: float | None = None,
    force: bool = False,
) -> JsonObject:
    """A model on runs → what ``pa10d compare --json`` says, and the history on the same runs.

    sheet: a folder for plots and words."""
    from pa10d.services.library import open_library
    from pa10d.services.models import compare_runs
    from pa10d.services.sheets import write_comparison_sheet

    found = compare_runs(
        open_library(data),
        model,
        runs,
        cutoff=cutoff,
        force=force,
        progress=progress,
    )
    if sheet is not None:
        progress(0.95, "plots")
        write_comparison_sheet(found, Path(sheet))
    return found.document()


def model_document(data: str, model: str) -> JsonObject:
    """A stored model with its parameters."""
    from pa10d.services.library import open_library
    from pa10d.services.model_details import model_details

    library = open_library(data)
    info = library.models.find(model)
    return vars(info) | model_details(library.models.load(info)).document()


def model_history(data: str, model: str) -> JsonObject:
    """A model and all it was made from, judged alike."""
    from pa10d.services.history import history
    from pa10d.services.library import open_library

    return {"items": [version.document() for version in history(open_library(data), model)]}


def model_text(data: str, model: str, format: Format, parameters: Parameters) -> JsonObject:
    """A model for other programs: its text, or the files of a folder, and what it cannot carry."""
    from pa10d.services.library import open_library
    from pa10d.services.models import export_model

    info, made = export_model(open_library(data), model, format, parameters)
    return {
        "name": info.name,
        "text": made.text,
        "files": dict(made.files),
        "not_carried": list(made.not_carried),
    }


def live_model_of(data: str, model: str) -> JsonObject:
    """The part of a stored model that the control loop evaluates."""
    from pa10d.control.live_model import live_model
    from pa10d.services.library import open_library

    return live_model(open_library(data).models.load(model)).document()


def diagnose(
    data: str,
    model: str,
    fit: list[str],
    validate: list[str],
    frozen: bool,
    effect: str | None,
    joints: list[int],
    progress: Progress,
    sheet: str | None = None,
    force: bool = False,
) -> JsonObject:
    """Which effect is missing → what ``pa10d diagnose --json`` says. sheet: a folder for plots."""
    from pa10d.diagnose.outcome.words import in_json
    from pa10d.services.diagnoses import diagnose_runs
    from pa10d.services.library import open_library
    from pa10d.services.sheets import write_diagnosis_sheet

    library = open_library(data)
    found = diagnose_runs(
        library, model, fit, validate, frozen=frozen, effect=effect, joints=joints,
        force=force, progress=progress,
    )  # fmt: skip
    if sheet is not None:
        progress(0.98, "plots")
        write_diagnosis_sheet(library, found, Path(sheet), model, fit, validate)
    return in_json(found)


def add(
    data: str,
    model: str,
    effect: str,
    joints: list[int],
    fit: list[str],
    name: str,
    replace: bool,
    progress: Progress,
    over: list[str] | None = None,
    force: bool = False,
) -> JsonObject:
    """A new version of a model with an effect fitted in."""
    from pa10d.diagnose.search.delivery import delivered
    from pa10d.services.diagnoses import add_effect
    from pa10d.services.library import open_library

    info, made, warnings = add_effect(
        open_library(data), model, effect, joints, fit, name=name, over=over or (),
        replace_model=replace, force=force, progress=progress,
    )  # fmt: skip
    return {
        "id": info.id,
        "name": info.name,
        "parent": made.parent,
        "change": made.change,
        "held_out": [float(v) for v in made.held_out["held out"]],
        **vars(delivered(made)),
        "warnings": warnings,
    }


def improve(
    data: str,
    model: str,
    fit: list[str],
    validate: list[str],
    name: str,
    replace: bool,
    progress: Progress,
    tried: list[JsonObject] | None = None,
    smooth: bool = False,
    force: bool = False,
) -> JsonObject:
    """New versions until nothing significant is left; tried: as ``improve_model`` has it."""
    from pa10d.diagnose.outcome.settling import NextExperiment
    from pa10d.services.diagnoses import improve_model
    from pa10d.services.library import open_library

    known = None if tried is None else [NextExperiment.read(one) for one in tried]
    return improve_model(
        open_library(data), model, fit, validate, name=name, replace_model=replace,
        tried=known, smooth=smooth, force=force, progress=progress,
    ).document()  # fmt: skip


def prepare_investigation(data: str, progress: Progress, **asked: Any) -> JsonObject:
    """A new investigation and its motions, planned; nothing moves."""
    from pa10d.investigation.begin import begin
    from pa10d.investigation.document import document

    state, seen = begin(data, progress=progress, **asked)
    return {**document(state, data), "motions": [one.document() for one in seen]}


def investigation_step(data: str, investigation: str, step: str, progress: Progress) -> JsonObject:
    """What one step of an investigation computes."""
    from pa10d.investigation.work import compute

    return vars(compute(data, investigation, step, progress))


def model_report(
    data: str, model: str, runs: list[str], progress: Progress, sheet: str | None = None
) -> JsonObject:
    """The report of a model, into the job's folder."""
    from pa10d.services.dossier import write_model_report
    from pa10d.services.library import open_library

    folder = Path(str(sheet))
    folder.mkdir(exist_ok=True)
    library = open_library(data)
    write_model_report(library, model, folder / "report.html", runs, progress=progress)
    return {"model": library.models.find(model).name, "file": "report.html"}


def begin_weighing(data: str, profile: str, weights: list[str], name: str | None) -> WeighingStatus:
    """A new weighing, its motion planned; nothing moves."""
    from pa10d.services.weighing.work import begin, status

    return status(begin(data, profile, weights, name))


def add_weight(data: str, weighing: str, weight: str) -> WeighingStatus:
    """Another weight at hand, and what it would bring."""
    from pa10d.services.weighing.work import add_weight as add
    from pa10d.services.weighing.work import status

    return status(add(data, weighing, weight))


def weighed(
    data: str, weighing: str, weight: int, runs: list[str], progress: Progress
) -> WeighingStatus:
    """What follows from a recording of a weighing."""
    from pa10d.services.weighing.work import weighed as take_in

    progress(0.1, "gains from what was recorded")
    return take_in(data, weighing, weight, runs)


def judge_weighing(data: str, weighing: str, progress: Progress) -> WeighingStatus:
    """What follows from the recordings of a weighing, where saying so was interrupted."""
    from pa10d.services.weighing.work import judge

    progress(0.1, "gains from what was recorded")
    return judge(data, weighing)
