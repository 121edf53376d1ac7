"""``pa10d run …``: recordings in, out and on show."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import Subcommands, WrongUsage, profile_option, replace_option
from pa10d.common.errors import UserError
from pa10d.common.words import joint_words

if TYPE_CHECKING:
    from pa10d.checks import CheckFinding
    from pa10d.store import RunInfo, RunStore

FORMATS = ("csv", "mcap", "parquet", "mat")
EVERY = "all"  # episodes


def add_commands(commands: Subcommands) -> None:
    """The family ``run``."""
    runs = commands.group("run", "recordings: import, list, show, check, export, repair, delete")
    parser = runs.add(
        "import",
        import_,
        "take a recording (CSV, ROS bag, Parquet, MAT …) into the store",
        examples=(
            "pa10d run import train.csv --profile robot.urdf --name train",
            "pa10d run import bag_folder --profile robot.urdf --check",
            "pa10d run import log.csv --map 't[ms]=time' 'joint_{n}_position[deg]=q'",
            "pa10d run import data_set --episode 12",
        ),
    )
    parser.add_argument(
        "file", type=Path, metavar="FILE|FOLDER", help="time,q1..qn,tau1..taun and more"
    )
    profile_option(parser)
    parser.add_argument("--name", metavar="N", help="its name (default: the file's)")
    parser.add_argument(
        "--check",
        action="store_true",
        help="say what to know before fitting, and store nothing that a fit must not use",
    )
    _map_option(parser)
    _part_options(parser, "a number, or 'all': each as a run of its own")
    parser.add_argument("--force", action="store_true", help="store it whatever --check says")
    replace_option(parser, "the run of this name")
    looking = runs.add(
        "preview",
        preview,
        "what a file's columns seem to be, and what to know of it; nothing is stored",
        examples=("pa10d run preview log.csv --profile robot.urdf",),
    )
    looking.add_argument("file", type=Path, metavar="FILE|FOLDER", help="a recording")
    profile_option(looking)
    _map_option(looking)
    _part_options(looking, "its number")
    runs.add("list", list_, "all runs, oldest first", examples=("pa10d run list",))
    _one_run(runs.add("show", show, "what is known of a run", examples=("pa10d run show train",)))
    checking = runs.add(
        "check", check, "what to know of a run before fitting", examples=("pa10d run check train",)
    )
    _one_run(checking)
    profile_option(checking)
    exporting = runs.add(
        "export",
        export,
        "write a run as a file",
        examples=("pa10d run export train --format mcap",),
    )
    _one_run(exporting)
    exporting.add_argument("--format", required=True, choices=FORMATS)
    exporting.add_argument("--out", type=Path, metavar="FILE", help="default: ./NAME.FORMAT")
    replace_option(exporting, "an existing file")
    runs.add(
        "repair",
        repair,
        "finish runs whose recorder was killed (done at every start too)",
        examples=("pa10d run repair",),
    )
    _one_run(runs.add("delete", delete, "remove a run", examples=("pa10d run delete train",)))


def import_(options: argparse.Namespace) -> Answer:
    """``run import``."""
    if options.episode == EVERY:
        return _import_each(options)
    return _import_one(options, options.name, options.episode)


def _import_each(options: argparse.Namespace) -> Answer:
    """Episodes that are refused are said; the others are stored all the same."""
    from pa10d.readers import episodes_of

    stored: list[Answer] = []
    refused = 0
    for episode in episodes_of(options.file):
        name = None if options.name is None else f"{options.name}-{episode}"
        try:
            stored.append(_import_one(options, name, episode))
        except UserError as error:
            refused += 1
            note(f"episode {episode}: {error}")
    if not stored:
        raise UserError(f"{options.file}: none of its {refused} episodes can be imported")
    note(f"{len(stored)} episodes stored" + (f", {refused} refused" if refused else ""))
    ids = "\n".join(answer.text for answer in stored)
    return Answer([answer.document for answer in stored], ids, status=1 if refused else 0)


def _import_one(options: argparse.Namespace, name: str | None, episode: int | None) -> Answer:
    from pa10d.cli.progress import progress_line
    from pa10d.readers import Part
    from pa10d.services.robots import load_robot
    from pa10d.services.runs import import_run

    store = _store(options)
    profile, robot = load_robot(options.profile)
    result = import_run(
        store, options.file, profile, robot, name=name, mapping=_mapping(options),
        replace=options.replace, check=options.check, force=options.force,
        progress=progress_line(), part=Part(options.topic, episode),
    )  # fmt: skip
    for warning in result.header_warnings if options.check else result.info.warnings:
        note(f"warning: {warning}")
    shown = [f for f in result.findings if options.check or f.severity == "error"]
    for finding in shown:
        note(str(finding))
    document = _brief(result.info) | {
        "warnings": result.info.warnings,
        "findings": [finding.document() for finding in shown],
    }
    if result.another and options.topic is None and episode is None:
        note(result.another)
    if result.kept:
        note(result.kept)
    note(f"{result.info.name}: {_extent(result.info)}")
    return Answer(document, result.info.id)


def _mapping(options: argparse.Namespace) -> list[str]:
    """--map, as it was said; what cannot be meant is so whatever the file has."""
    from pa10d.store.column_mapping import read_mapping

    try:
        read_mapping(options.map)
    except UserError as error:
        raise WrongUsage(str(error)) from error
    return list(options.map)


def preview(options: argparse.Namespace) -> Answer:
    """``run preview``; exit status 1 where an import would be refused."""
    from pa10d.cli.progress import progress_line
    from pa10d.readers import Part
    from pa10d.services.import_preview import preview_recording
    from pa10d.services.robots import load_robot

    if options.episode == EVERY:
        raise WrongUsage("--episode all: expected the number of one episode to look at")
    profile, robot = load_robot(options.profile)
    found = preview_recording(
        options.file, profile, robot, mapping=_mapping(options), progress=progress_line(),
        part=Part(options.topic, options.episode),
    )  # fmt: skip
    head = ["column", "read as", "unit", "low", "high", "first values"]
    rows = [
        [c.name, c.field or "–", c.unit, f"{c.low:.4g}", f"{c.high:.4g}",
         "  ".join(f"{v:.6g}" for v in c.first)]
        for c in found.columns
    ]  # fmt: skip
    lines = [table(head, rows), f"and {found.left_out} more columns" if found.left_out else ""]
    lines += ["", *found.remarks]
    asked = options.topic is not None or options.episode is not None
    lines += [found.parts.another] if found.parts and not asked else []
    findings = [one.finding for one in found.findings]
    lines += [str(finding) for finding in findings]
    lines += [f"error: {found.problem}" if found.problem else "", found.line]
    wrong = found.problem or any(finding.severity == "error" for finding in findings)
    return Answer(found.document(), "\n".join(filter(None, lines)), status=1 if wrong else 0)


def list_(options: argparse.Namespace) -> Answer:
    """``run list``."""
    store = _store(options)
    for other in store.set_aside():
        note(f"warning: set aside: {other.reason}")
    infos = store.all()
    rows = [[i.id, i.name, i.status, _extent(i), i.profile, " ".join(i.tags)] for i in infos]
    head = ["id", "name", "status", "extent", "profile", "tags"]
    return Answer([_brief(i) for i in infos], table(head, rows) if rows else "no runs yet")


def show(options: argparse.Namespace) -> Answer:
    """``run show``."""
    from pa10d.services.summaries import joint_summaries

    store = _store(options)
    info = store.find(options.run_)
    joints = joint_summaries(store, info)
    lines = [f"{key}: {value}" for key, value in _described(info).items() if value not in ("", ())]
    head = ["joint", "name", "q min", "q max", "|dq| max", "tau min", "tau max"]
    rows = [
        [str(j.joint), j.name, f"{j.q_min:.4g}", f"{j.q_max:.4g}", f"{j.dq_max:.4g}",
         f"{j.tau_min:.4g}", f"{j.tau_max:.4g}"]
        for j in joints
    ]  # fmt: skip
    lines += ["", table(head, rows)] if rows else []
    return Answer(info.document() | {"per_joint": [vars(j) for j in joints]}, "\n".join(lines))


def check(options: argparse.Namespace) -> Answer:
    """``run check``."""
    from pa10d.services.robots import load_robot
    from pa10d.services.runs import check_run

    profile, robot = load_robot(options.profile)
    findings: list[CheckFinding] = check_run(_store(options), options.run_, robot, profile)
    document = {"findings": [finding.document() for finding in findings]}
    wrong = any(finding.severity == "error" for finding in findings)
    return Answer(document, "\n".join(map(str, findings)), status=1 if wrong else 0)


def export(options: argparse.Namespace) -> Answer:
    """``run export``."""
    from pa10d.store.export import export_run

    store = _store(options)
    info = store.find(options.run_)
    out = options.out or Path(f"{info.name}.{options.format}")
    export_run(store, info, options.format, out, options.replace)
    return Answer({"id": info.id, "name": info.name, "file": out.absolute()}, str(out))


def repair(options: argparse.Namespace) -> Answer:
    """``run repair``: opening the store has done it."""
    repaired = _store(options).repaired
    lines = [f"{i.name} ({i.id}): {i.status}, {i.reason or _extent(i)}" for i in repaired]
    return Answer([_brief(i) for i in repaired], "\n".join(lines) or "nothing to repair")


def delete(options: argparse.Namespace) -> Answer:
    """``run delete``."""
    info = _store(options).delete(options.run_)
    return Answer(_brief(info), f"deleted {info.name} ({info.id})")


def _store(options: argparse.Namespace) -> RunStore:
    from pa10d.store import RunStore

    return RunStore(options.data)


def _map_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--map", metavar="COL[unit]=FIELD", nargs="+", action="extend", default=[],
        help="read column COL as FIELD: time, q1, tau1, dq1, i1, temp1 …; {n} in COL stands for "
        "the joint's number: 't[ms]=time' 'joint_{n}_position[deg]=q'",
    )  # fmt: skip


def _part_options(parser: argparse.ArgumentParser, episodes: str) -> None:
    parser.add_argument(
        "--topic",
        metavar="NAME",
        help="of a bag that has joint states on several, joined by a comma: /left,/right; a bus of "
        "a CAN log",
    )
    parser.add_argument(
        "--episode", metavar="N", type=_episode, help=f"of a LeRobot data set: {episodes}"
    )


def _episode(text: str) -> int | str:
    if text == EVERY:
        return text
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a number from 0 or {EVERY!r}")
    return int(text)


def _one_run(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run_", metavar="RUN", help="name, id or the start of an id")


def _brief(info: RunInfo) -> dict[str, object]:
    keys = ("id", "name", "created", "profile", "status", "reason", "samples", "duration", "rate")
    return {key: getattr(info, key) for key in keys} | {
        "joints": len(info.joints),
        "tags": info.tags,
        "repaired": info.repaired,
    }


def _described(info: RunInfo) -> dict[str, object]:
    from pa10d.checks import CheckFinding

    shown = info.document()
    shown |= {"duration": f"{info.duration:.3f} s", "rate": f"{info.rate:.6g} Hz"}
    for key in ("joints", "channels", "tags"):
        shown[key] = ", ".join(shown[key])
    if info.unit_given:
        shown["unit_given"] = joint_words(info.unit_given)
    shown["excluded"] = ", ".join(f"{begin:g} to {end:g} s" for begin, end in info.excluded)
    findings = (str(CheckFinding(**one)) for one in info.findings or ())
    for key, said in (("warnings", info.warnings), ("findings", findings)):
        shown[key] = "".join(f"\n  {line}" for line in said)
    del shown["format"]
    return shown


def _extent(info: RunInfo) -> str:
    return f"{info.samples} samples, {info.duration:.1f} s, {info.rate:.6g} Hz"
