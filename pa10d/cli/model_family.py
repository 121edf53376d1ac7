"""``pa10d model …``: torque models on show, their history, and taken elsewhere."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import Subcommands, replace_option
from pa10d.cli.models import _library, _model, _rows
from pa10d.cli.progress import progress_line
from pa10d.common.jsonable import JsonObject
from pa10d.export.endings import ENDINGS, FOLDERS, FORMATS

if TYPE_CHECKING:
    from pa10d.effects import Value
    from pa10d.services.history import Version
    from pa10d.store.models import ModelInfo


def add_commands(commands: Subcommands) -> None:
    """The family ``model``."""
    models = commands.group("model", "torque models: list, show, history, export")
    models.add("list", list_, "all models, oldest first", examples=("pa10d model list",))
    _model(
        models.add(
            "show",
            show,
            "a model's parameters with units and standard errors",
            examples=("pa10d model show m0",),
        )
    )
    parser = models.add(
        "history",
        history,
        "what a model was made from, all judged alike",
        examples=(
            "pa10d model history m1",
            "pa10d model history m1 --runs valid",
        ),
    )
    _model(parser)
    _judges(parser, "those that the model was judged by, else fitted to")
    parser = models.add(
        "report",
        report,
        "one file to send on: robot, runs, fit, parameters, errors, versions",
        examples=(
            "pa10d model report m1",
            "pa10d model report m1 --runs valid --out m1.html",
        ),
    )
    _model(parser)
    _judges(parser, "those that the model was judged by")
    parser.add_argument("--out", type=Path, metavar="FILE", help="default: ./MODEL.html")
    parser = models.add(
        "export",
        export,
        "a model for other programs",
        examples=(
            "pa10d model export m1 --format mjcf --out arm.xml",
            "pa10d model export m1 --format c",
            "pa10d model export m1 --format ros2_control --out src/m1_feed_forward",
            "pa10d model export m1 --format tables --out tables",
        ),
    )
    _model(parser)
    parser.add_argument("--format", required=True, choices=FORMATS)
    parser.add_argument(
        "--parameters", choices=("feasible", "free"), default="feasible",
        help="feasible: bodies that can exist (default); free: the unconstrained fit",
    )  # fmt: skip
    parser.add_argument(
        "--out",
        type=Path,
        metavar="PATH",
        help="default: ./MODEL.urdf, .py, .h, …; ros2_control and tables are folders",
    )
    replace_option(parser, "an existing file")


def report(options: argparse.Namespace) -> Answer:
    """``model report``."""
    from pa10d.services.dossier import write_model_report

    library = _library(options)
    info = library.models.find(options.model_)
    path = (options.out or Path(f"{info.name}.html")).absolute()
    made = write_model_report(library, info.id, path, options.runs, progress=progress_line())
    return Answer({"id": info.id, "name": info.name, "report": str(made)}, str(made))


def _judges(parser: argparse.ArgumentParser, default: str) -> None:
    parser.add_argument(
        "--runs", nargs="+", action="extend", default=[], metavar="RUN",
        help=f"runs to judge by (default: {default})",
    )  # fmt: skip


def list_(options: argparse.Namespace) -> Answer:
    """``model list``."""
    store = _library(options).models
    for other in store.set_aside():
        note(f"warning: set aside: {other.reason}")
    infos = store.all()
    head = ["id", "name", "created", "from", "change", "RMS N·m"]
    rows = [
        [
            i.id, f"{i.name} (replaced)" if i.replaced else i.name, i.created[:19],
            i.parent_name or "", i.change, _several(i.rms),
        ]
        for i in infos
    ]  # fmt: skip
    return Answer([_brief(i) for i in infos], table(head, rows) if rows else "no models yet")


def show(options: argparse.Namespace) -> Answer:
    """``model show``."""
    from pa10d.services.model_details import model_details

    library = _library(options)
    info = library.models.find(options.model_)
    model = library.models.load(info)
    details = model_details(model)
    path = library.models.path(info)
    rows = [[p.name, *_known(p.value), p.value.unit, p.meaning] for p in details.parameters]
    lines = [
        f"{info.name} ({info.id}), {info.change}, from {info.parent_name or 'nothing'}",
        f"runs {', '.join(info.runs)}; cut-off {info.cutoff_hz:g} Hz; file {path}",
        table(["parameter", "value", "± 1 σ", "unit", "is"], rows),
        table(["joint", f"RMS {model.robot.torque_units()}"], _rows(info.joints, info.rms)),
        *details.impossible,
    ]
    return Answer(_brief(info) | details.document() | {"file": path}, "\n".join(lines))


def _errors(version: Version, units: str) -> list[str]:
    """What a version is, and its error, in the units of its joints."""
    info, found = version.info, version.judgement
    head = f"{info.name} ({info.id}): {info.change}"
    if found is None:
        return [head, f"  fit       {_several(info.rms)} {units} on {', '.join(info.runs)}"]
    noise = _several(found.floor.values).replace("nan", "?")
    return [head, f"  error     {_several(found.rms)} {units}", f"  noise     {noise} {units}"]


def history(options: argparse.Namespace) -> Answer:
    """``model history``."""
    from pa10d.judgement import first_and_last
    from pa10d.services.history import history as judged_alike

    library = _library(options)
    versions = judged_alike(library, options.model_, options.runs)
    units = library.models.load(versions[-1].info).robot.torque_units()
    lines = [line for version in versions for line in _errors(version, units)]
    first, judged = versions[0].info, [v.judgement for v in versions if v.judgement is not None]
    if judged:
        last, mask = judged[-1], first_and_last(judged[0], judged[-1])
        lines.append(f"all judged on {', '.join(last.runs)}; low-pass {last.cutoff:g} Hz, {mask}")
    if first.parent is not None:
        lines.insert(0, f"{first.parent_name} ({first.parent}): not in this store")
    return Answer([version.document() for version in versions], "\n".join(lines))


def export(options: argparse.Namespace) -> Answer:
    """``model export``."""
    from pa10d.common.errors import UserError
    from pa10d.services.models import export_model, write_export

    library, parameters = _library(options), options.parameters
    info, made = export_model(library, options.model_, options.format, parameters)
    folder = options.format in FOLDERS
    ending = f"_{options.format}" if folder else f".{ENDINGS[options.format]}"
    out = options.out or Path(f"{info.name}{ending}")
    if out.exists() and not options.replace:
        raise UserError(f"{out}: there is such a file already; expected another or --replace")
    said = [*made.warnings, *made.not_carried]
    if made.loss is not None:
        said.append(made.loss.sentence)
    for line in said:
        note(f"warning: {line}")
    write_export(made, out.absolute())
    document = {
        "id": info.id, "name": info.name, "file": out.absolute(), "format": made.format,
        "parameters": made.parameters, "not_carried": list(made.not_carried),
        "warnings": list(made.warnings), "files": sorted(made.files),
        "loss": None if made.loss is None else vars(made.loss),
    }  # fmt: skip
    return Answer(document, f"{out} ({made.parameters} parameters)")


def _several(values: Iterable[float]) -> str:
    return " ".join(f"{value:.3g}" for value in values)


def _known(value: Value) -> list[str]:
    """Value and standard error, or that the data leave it open."""
    if not value.determined:
        return ["not determined", ""]
    return [f"{value.value:.5g}", f"{value.std_error:.2g}"]


def _brief(info: ModelInfo) -> JsonObject:
    keys = (
        "id", "name", "created", "robot", "joints", "parent", "parent_name", "change", "effects",
        "runs", "cutoff_hz", "feasible", "rms", "held_out", "noise_floor", "software", "replaced",
    )  # fmt: skip
    return {key: getattr(info, key) for key in keys}
