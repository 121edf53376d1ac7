"""``pa10d identify`` and ``compare``: torque models made and judged."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import (
    Subcommands,
    WrongUsage,
    file_option,
    force_option,
    profile_option,
    replace_option,
)
from pa10d.cli.progress import progress_line
from pa10d.common.jsonable import JsonObject

if TYPE_CHECKING:
    from pa10d.services.library import Library


def add_commands(commands: Subcommands) -> None:
    """``identify`` and ``compare``."""
    parser = commands.add(
        "identify",
        identify,
        "fit the textbook torque model to runs",
        examples=(
            "pa10d identify train --profile robot.urdf --name m0",
            "pa10d identify monday tuesday --with torque_offset --name m0",
            "pa10d identify monday --leave-out monday 12 14.5 --prior 30 --name m0",
            "pa10d identify monday --prior 'Fc3=12±2' --prior 'link J7: m = 1.5 +- 1 %' --name m0",
        ),
    )
    _runs(parser)
    profile_option(parser)
    parser.add_argument("--name", required=True, metavar="MODEL", help="the new model's name")
    parser.add_argument(
        "--cutoff", type=float, metavar="HZ", help="low-pass of the fit (default: from the data)"
    )
    parser.add_argument(
        "--with", dest="effects", metavar="EFFECT", nargs="+", action="extend", default=[],
        help="further effects, on every joint (torque_offset) or on one (stribeck:2)",
    )  # fmt: skip
    parser.add_argument(
        "--faster-than", type=float, nargs="+", metavar="V",
        help="rad/s per joint: fit only samples in which the joint is faster, where friction is "
        "linear",
    )  # fmt: skip
    parser.add_argument(
        "--robust", action="store_true",
        help="let samples far off the model count less: knocks, collisions, glitches",
    )  # fmt: skip
    parser.add_argument(
        "--leave-out", dest="left_out", nargs=3, metavar=("RUN", "BEGIN", "END"), action="append",
        default=[], help="seconds of a run that this fit does not use; may be given several times",
    )  # fmt: skip
    parser.add_argument(
        "--prior", action="append", default=[], metavar="PERCENT|NAME=VALUE±ERROR",
        help="what is known beforehand: bodies are the URDF's, give or take this much of what is "
        "usual for a link; or one parameter and its standard error in SI, Fc3=12±2 (or +-): a name "
        "from the table of parameters, or a link's own (link J7: m); may be given several times",
    )  # fmt: skip
    force_option(parser)
    replace_option(parser, "the model of this name (the old one stays under its id)")

    parser = commands.add(
        "compare",
        compare,
        "how large a model's error is, and where",
        examples=(
            "pa10d compare m0 valid",
            "pa10d compare m0 valid --report where.html",
        ),
    )
    _model(parser)
    _runs(parser)
    parser.add_argument(
        "--cutoff", type=float, metavar="HZ",
        help="low-pass of the judgement (default: the band that all versions of the model share)",
    )  # fmt: skip
    file_option(parser, "report", "write an HTML report")
    force_option(parser)


def identify(options: argparse.Namespace) -> Answer:
    """``identify``."""
    from pa10d.identify import FitOptions
    from pa10d.services.models import identify_runs

    asked = {"cutoff": options.cutoff, "with_effects": options.effects, "robust": options.robust,
             "faster_than": options.faster_than, **_known(options.prior)}  # fmt: skip
    made = identify_runs(
        _library(options), options.runs, options.profile, name=options.name,
        options=FitOptions.read(asked), left_out=_stretches(options.left_out),
        replace=options.replace, force=options.force,
        progress=progress_line(),
    )  # fmt: skip
    found = made.summary
    for warning in found.get("warnings", ()):
        note(f"warning: {warning}")
    lines = [
        f"{made.info.name} ({made.info.id})",
        f"{found['base_parameters']} base parameters, {found['inertial_base_parameters']} of them "
        f"inertial; condition number {found['condition_number']:.4g}; cut-off "
        f"{found['cutoff_hz']:.4g} Hz; {'feasible' if found['feasible'] else 'not feasible'}",
        table(
            ["joint", f"RMS {made.model.robot.torque_units()}"],
            _rows(made.info.joints, made.info.rms),
        ),
    ]
    return Answer(found, "\n".join(lines))


def _known(said: Sequence[str]) -> JsonObject:
    """A number is the share of the URDF's bodies, all else single parameters."""
    shares = [word for word in said if "=" not in word]
    if len(shares) > 1:
        raise WrongUsage(f"--prior {' '.join(shares)}: expected one share of the URDF's bodies")
    try:
        percent = float(shares[0].removesuffix("%")) if shares else None
    except ValueError as error:
        raise WrongUsage(
            f"--prior {shares[0]}: expected a share in %, or NAME=VALUE±ERROR, such as Fc3=12±2"
        ) from error
    return {"prior": percent, "given": [word for word in said if "=" in word]}


def _stretches(given: Sequence[Sequence[str]]) -> list[tuple[str, float, float]]:
    try:
        return [(run, float(begin), float(end)) for run, begin, end in given]
    except ValueError as error:
        said = " ".join(given[-1])
        raise WrongUsage(f"--leave-out {said}: expected a run and two times in seconds") from error


def compare(options: argparse.Namespace) -> Answer:
    """``compare``."""
    from pa10d.services.models import compare_runs, write_report

    library = _library(options)
    found = compare_runs(
        library, options.model_, options.runs, cutoff=options.cutoff, force=options.force,
        progress=progress_line(),
    )  # fmt: skip
    document = found.document()
    for warning in document["warnings"]:
        note(f"warning: {warning}")
    if options.report is not None:
        document["report"] = str(write_report(found, options.report.absolute()))
        note(f"report: {document['report']}")
    pooled = document["pooled"]
    unit = found.comparison.model.robot.torque_units()
    head = ["joint", f"RMS {unit}", "noise floor", "ratio", "RMS raw", "max", "NRMSE", "R²"]
    rows = [
        [
            f"{j + 1} {name}",
            f"{pooled['rms'][j]:.4g}",
            *_against(
                pooled["rms"][j], pooled["noise_floor"][j], pooled["noise_floor_std_error"][j]
            ),
            *(f"{pooled[key][j]:.4g}" for key in ("rms_raw", "max", "nrmse", "r2")),
        ]
        for j, name in enumerate(found.info.joints)
    ]
    places = [*(place["sentence"] for place in document["where"]), *pooled["spread"]]
    text = [
        f"{found.info.name} on {', '.join(run.name for run in found.runs)}, "
        f"low-pass {document['cutoff_hz']:g} Hz, {document['mask']}",
        table(head, rows),
        *(places or ["nowhere more than elsewhere: no region stands out"]),
    ]
    return Answer(document, "\n".join(text))


def _against(rms: float, floor: float | None, error: float | None) -> tuple[str, str]:
    """A noise floor, with its own doubt where that changes what a ratio to it says."""
    from pa10d.diagnose.constants import UNSURE_FLOOR

    if not floor:
        return "not known", "–"
    doubt = f" ± {100.0 * error / floor:.0f} %" if error and error > UNSURE_FLOOR * floor else ""
    return f"{floor:.4g}{doubt}", f"{rms / floor:.2f}"


def _library(options: argparse.Namespace) -> Library:
    from pa10d.services.library import open_library

    return open_library(options.data)


def _runs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("runs", metavar="RUN", nargs="+", help="name, id or the start of an id")


def _model(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model_", metavar="MODEL", help="name, id or the start of an id")


def _rows(joints: Sequence[str], values: Sequence[float]) -> list[list[str]]:
    return [
        [f"{j + 1} {name}", f"{value:.4g}"]
        for j, (name, value) in enumerate(zip(joints, values, strict=True))
    ]
