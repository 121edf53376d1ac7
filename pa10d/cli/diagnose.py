"""``pa10d diagnose``, ``add`` and ``improve``: which effect is missing, and a model that has it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import (
    Subcommands,
    WrongUsage,
    current,
    file_option,
    force_option,
    replace_option,
)
from pa10d.cli.daemon_client import improve_by_daemon, robot_options
from pa10d.cli.models import _library, _model
from pa10d.cli.progress import progress_line
from pa10d.common.jsonable import JsonObject
from pa10d.common.words import listed

if TYPE_CHECKING:
    from pa10d.diagnose.outcome.diagnosis import Diagnosis, Finding
    from pa10d.dynamics import Robot


def add_commands(commands: Subcommands) -> None:
    """``diagnose``, ``add`` and ``improve``."""
    parser = commands.add(
        "diagnose",
        diagnose,
        "which physical effect is missing, or what changed",
        examples=(
            "pa10d diagnose m0 --fit train --validate valid",
            "pa10d diagnose m0 --fit monday --validate friday --frozen",
            "pa10d diagnose m0 --fit train --effect stribeck --joint 4 --report why.html",
        ),
    )
    _model(parser)
    _sides(parser)
    parser.add_argument(
        "--frozen", action="store_true", help="do not refit the model: what changed since?"
    )
    parser.add_argument("--effect", metavar="E", help="test one suspicion only")
    _joints(parser)
    _report(parser)
    force_option(parser)

    parser = commands.add(
        "add",
        add,
        "a new version of a model with an effect fitted in",
        examples=(
            "pa10d add m0 stribeck --joint 4 --fit train --name m1",
            "pa10d add m0 smooth_map --joint 2 --over q,dq --fit train --name m1",
        ),
    )
    _model(parser)
    parser.add_argument("effect", metavar="EFFECT", help="of the library, or smooth_map")
    _joints(parser)
    parser.add_argument(
        "--over", metavar="X,Y", default="",
        help="of smooth_map: one or two quantities, such as q,dq or q2,'q4 0.4 s ago', as a "
        "diagnosis names them in 'depends_on'",
    )  # fmt: skip
    parser.add_argument("--fit", nargs="+", action="extend", required=True, metavar="RUN")
    parser.add_argument("--name", required=True, metavar="NEW", help="the new version's name")
    force_option(parser)
    replace_option(parser, "the model of this name (the old one stays under its id)")

    parser = commands.add(
        "improve",
        improve,
        "diagnose and add until nothing significant is left",
        examples=(
            "pa10d improve m0 --fit train --validate valid --name best",
            "pa10d improve m0 --fit train --name best --experiments",
        ),
    )
    _model(parser)
    _sides(parser)
    parser.add_argument("--name", required=True, metavar="NEW", help="the last version's name")
    _report(parser)
    parser.add_argument(
        "--experiments", action="store_true",
        help="move the arm: run what settles a doubt (by the daemon, or one of its own)",
    )  # fmt: skip
    parser.add_argument(
        "--smooth", action="store_true",
        help="take away what no effect explains by smooth maps (which explain nothing)",
    )  # fmt: skip
    robot_options(parser)
    force_option(parser)
    replace_option(parser, "models of these names (the old ones stay under their ids)")


def diagnose(options: argparse.Namespace) -> Answer:
    """``diagnose``."""
    from pa10d.diagnose.outcome.words import in_json
    from pa10d.services.diagnoses import diagnose_runs

    if options.joint and options.effect is None:
        raise WrongUsage("--joint: given without --effect; expected the effect to test there")
    found = diagnose_runs(
        _library(options), options.model_, options.fit, options.validate, frozen=options.frozen,
        effect=options.effect, joints=options.joint, force=options.force, progress=progress_line(),
    )  # fmt: skip
    document = in_json(found)
    _write_report(options, found, document)
    return Answer(document, in_words(found))


def add(options: argparse.Namespace) -> Answer:
    """``add``."""
    from pa10d.diagnose.search.delivery import delivered
    from pa10d.services.diagnoses import add_effect

    info, model, warnings = add_effect(
        _library(options), options.model_, options.effect, options.joint, options.fit,
        name=options.name, over=[x.strip() for x in options.over.split(",") if x.strip()],
        replace_model=options.replace, force=options.force, progress=progress_line(),
    )  # fmt: skip
    for warning in warnings:
        note(f"warning: {warning}")
    held = model.held_out["held out"]
    document = {
        "id": info.id,
        "name": info.name,
        "parent": model.parent,
        "change": model.change,
        "held_out": [float(v) for v in held],
        **vars(delivered(model)),
        "warnings": warnings,
    }
    errors = ", ".join(f"{v:.4g} {model.robot.torque_unit(j)}" for j, v in enumerate(held))
    text = f"{info.name} ({info.id}): {model.change}; error on data held out of the fit, joint by "
    text += f"joint: {errors} RMS"
    text += f"\nto undo, go on with {model.parent}: it stays as it is"
    return Answer(document, text)


def improve(options: argparse.Namespace) -> Answer:
    """``improve``."""
    from pa10d.services.diagnoses import improve_model

    if options.experiments:
        if options.report is not None:
            raise WrongUsage(
                "--report: not together with --experiments, which the daemon runs; afterwards "
                f"'pa10d diagnose {options.name} --fit … --report FILE' shows what is left"
            )
        current.patient = True  # it may have started a daemon
        return improve_by_daemon(options)

    made = improve_model(
        _library(options), options.model_, options.fit, options.validate, name=options.name,
        replace_model=options.replace, smooth=options.smooth, force=options.force,
        progress=progress_line(),
    )  # fmt: skip
    for warning in made.elsewhere:
        note(f"warning: {warning}")
    text = in_words(made.diagnosis)
    if made.infos:
        text += "\nstored: " + ", ".join(f"{i.name} ({i.change})" for i in made.infos)
        text += f"\nto undo, go on with {made.infos[0].parent_name}: it stays as it is"
    else:
        text += "\nnothing stored: there is nothing to add"
    document = made.document()
    _write_report(options, made.diagnosis, document)
    return Answer(document, text)


def _write_report(options: argparse.Namespace, found: Diagnosis, document: JsonObject) -> None:
    from pa10d.services.diagnoses import write_diagnosis_report

    if options.report is None:
        return
    document["report"] = str(
        write_diagnosis_report(
            _library(options), found, options.report.absolute(), model=options.model_,
            fit=options.fit, validate=options.validate,
        )
    )  # fmt: skip
    note(f"report: {document['report']}")


def in_words(found: Diagnosis) -> str:
    """A diagnosis for the terminal."""
    import numpy as np

    from pa10d.diagnose.outcome.words import headline
    from pa10d.judgement import first_and_last

    n = len(found.rms)
    lines = [f"{found.heading}:" if found.findings else headline(found)]
    for number, finding in enumerate(found.findings, 1):
        lines.append(f"{number}. {finding.sentence}")
        values = ", ".join(
            f"{name} = {v}" for name, v in finding.parameters.items() if v.determined
        )
        if values:
            lines.append(f"   {finding.term.label}: {values}")
        lines += _open(finding, found.model.robot)
        if finding.next_experiment is not None:
            lines.append(
                f"   settle the doubt with: {finding.next_experiment.command} "
                "(--to motion.csv where another program moves the arm)"
            )
    maps = {s.joint: s for s in found.mapped}
    for line in found.remaining:
        lines.append(line.sentence)
        if line.joint in maps and not found.frozen:
            lines.append(
                "   a smooth map removes that part, and explains nothing: pa10d add … smooth_map "
                f"--joint {line.joint + 1} --over '{','.join(line.depends_on)}'"
            )
    lines += [f"warning: {warning}" for warning in found.warnings]
    first, *others = (word for word, _ in found.stages)
    unit = found.model.robot.torque_units()
    head = ["joint", f"RMS {unit} {first}", *others, "noise floor"]
    rows = [
        [
            str(j + 1),
            *(f"{errors[j]:.4g}" for _, errors in found.stages),
            f"{found.noise_floor[j]:.4g}" if np.isfinite(found.noise_floor[j]) else "not known",
        ]
        for j in range(n)
    ]
    mask = first_and_last(found.as_given, found.left)
    where = f"judged on {found.judged_on}; low-pass {found.cutoff:g} Hz, {mask}"
    lines += [table(head, rows), where]
    if found.frozen and not (found.beside or found.findings):
        lines.append(
            "RMS is that of the model as it was given; the lines on its joints are of it moved, "
            "within its own doubt, to suit the fitted runs"
        )
    return "\n".join(lines)


def _open(finding: Finding, robot: Robot) -> list[str]:
    """What of it is not determined, and what would tell."""
    kind = finding.term.effect
    never = kind.never_shown(robot, finding.term.joints)
    by: dict[str, list[str]] = {}
    left = (name for name, v in finding.parameters.items() if not (v.determined or v.beyond))
    for name in left:
        would = f"would be by: {kind.shown_by(name)}"
        by.setdefault("no motion of this arm shows it" if name in never else would, []).append(name)
    return [f"   not determined: {listed(names)}; {told}" for told, names in by.items()]


def _sides(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--fit", nargs="+", action="extend", required=True, metavar="RUN", help="runs to fit"
    )
    parser.add_argument(
        "--validate", nargs="+", action="extend", default=[], metavar="RUN",
        help="runs to judge by (default: every other block of time of the fitted ones)",
    )  # fmt: skip


def _joints(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--joint", nargs="+", type=int, action="extend", default=[], metavar="J",
        help="joints, numbered from 1 (two for effects of pairs)",
    )  # fmt: skip


def _report(parser: argparse.ArgumentParser) -> None:
    file_option(parser, "report", "write an HTML report")
