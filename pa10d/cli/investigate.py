"""``pa10d investigate``: from an arm or recordings to a model, what it lacks, and a report."""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import Subcommands, WrongUsage, current, file_option, force_option, positive
from pa10d.cli.daemon_client import daemon_for, progress_line, robot_options
from pa10d.cli.story import tell
from pa10d.common.errors import Unsound, UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.words import listed

if TYPE_CHECKING:
    from pa10d.client import Client

OVER = ("done", "left_out")


def add_commands(commands: Subcommands) -> None:
    """``investigate``."""
    parser = commands.add(
        "investigate",
        investigate,
        "all of it: record (or the given runs), identify, compare, diagnose, settle doubts, add, "
        "judge on fresh motion, report",
        examples=(
            "pa10d investigate --preview",
            "pa10d investigate --profile arm.yaml --minutes 6",
            "pa10d investigate --profile arm.yaml --fit a b --validate c --report found.html",
            "pa10d investigate --since m0",
            "pa10d investigate --resume investigation",
        ),
    )
    robot_options(parser)
    parser.add_argument(
        "--minutes", type=positive, metavar="M",
        help="of motion, at most; what does not fit is left out, and said (default: 15)",
    )  # fmt: skip
    parser.add_argument(
        "--fit", nargs="+", action="extend", default=[], metavar="RUN",
        help="recordings to fit to: nothing moves, and no daemon is needed",
    )  # fmt: skip
    parser.add_argument(
        "--validate", nargs="+", action="extend", default=[], metavar="RUN",
        help="recordings to judge by (default: every other block of time of the fitted ones)",
    )  # fmt: skip
    parser.add_argument(
        "--since", metavar="MODEL", help="ask what has changed since this model was identified"
    )
    parser.add_argument("--name", help="of the investigation and its models (default: numbered)")
    parser.add_argument(
        "--preview", action="store_true", help="the motions and their times only; nothing moves"
    )
    parser.add_argument(
        "--resume", metavar="NAME", help="go on with one that was stopped, failed or paused"
    )
    parser.add_argument(
        "--recover", action="store_true",
        help="bring an arm that stands outside its position limits back inside first, slowly",
    )  # fmt: skip
    file_option(parser, "report", "a copy of the HTML report, what settles doubts beside it")
    force_option(parser)


def investigate(options: argparse.Namespace) -> Answer:
    """``investigate``."""
    from pa10d.investigation.begin import begin
    from pa10d.investigation.document import document

    if options.validate and not options.fit:
        raise WrongUsage("--validate: given without --fit; expected runs to fit a model to, too")
    if options.resume is not None:
        state = _resumable(options)
    else:
        state, motions = begin(
            _data(options), options.profile, name=options.name, minutes=options.minutes,
            since=options.since, fit=options.fit, validate=options.validate, force=options.force,
            keep=not options.preview, progress=progress_line(),
        )  # fmt: skip
        if options.preview:
            shown = {**document(state, _data(options)),
                     "motions": [motion.document() for motion in motions]}  # fmt: skip
            return Answer(shown, _motions_in_words(shown))
    found = document(state, _data(options))
    if state.moves:
        note(_motions_in_words(found))
    note(f"Ctrl-C stops it; 'pa10d investigate --resume {state.name}' goes on from there.")
    found = _by_daemon(options, found) if state.moves else _here(options, found)
    if options.report is not None and found["report"] is not None:
        _copied(found, options.report.absolute())
    return Answer(found, in_words(found), status=0 if found["status"] == "done" else 1)


def _resumable(options: argparse.Namespace) -> Any:
    from pa10d.investigation.archive import Archive

    state = Archive(_data(options)).find(options.resume)
    if options.fit or options.validate or options.since or options.minutes is not None:
        raise WrongUsage(
            "--resume: goes on with what was asked for before; expected no --fit, --validate, "
            "--since or --minutes"
        )
    return state


def _here(options: argparse.Namespace, found: JsonObject) -> JsonObject:
    from pa10d.investigation.archive import Archive
    from pa10d.investigation.document import document
    from pa10d.investigation.on_data import carry_out

    def told(state: Any, step: Any) -> None:
        _tell_step(step.model_dump())

    data = _data(options)
    try:
        carry_out(data, found["id"], progress_line(), told)
    except Unsound:
        raise
    except UserError:
        pass  # the document says it
    return document(Archive(data).load(found["id"]), data)


def _by_daemon(options: argparse.Namespace, found: JsonObject) -> JsonObject:
    from pa10d.client import JobFailed

    current.patient = True  # it may have started a daemon
    with daemon_for(options) as client:
        try:
            return follow(client, found["id"], options.recover)
        except JobFailed:
            return client.investigation(found["id"])


def follow(client: Client, investigation: str, recover: bool = False) -> JsonObject:
    """Carry it out by the daemon, telling each step. recover: see ``Client.investigate``."""
    known: dict[str, str] = {}

    def tell_news(state: JsonObject) -> None:
        for step in state["steps"]:
            if known.get(step["id"]) != step["status"]:
                known[step["id"]] = step["status"]
                _tell_step(step)

    return client.investigate(investigation, progress_line(), tell_news, recover)


def _tell_step(step: JsonObject) -> None:
    if step["status"] == "running":
        tell(f"{step['title']} …")
    elif step["status"] in OVER and step["said"]:
        tell(f"   {step['said']}")


def _motions_in_words(found: JsonObject) -> str:
    steps = [step for step in found["steps"] if step["experiment"] is not None]
    rows = [
        [step["experiment"]["kind"], step["purpose"],
         f"{step['seconds']:.0f} s" if step["status"] != "left_out" else "left out",
         step["why"] if step["status"] != "left_out" else step["said"]]
        for step in steps
    ]  # fmt: skip
    total = sum(s["seconds"] for s in steps if s["status"] != "left_out")
    budget = found["budget_minutes"]
    most = ""
    if budget is not None:
        left = 60.0 * budget - total
        most = f"; of the budget of {budget:g} minutes {left:.0f} s are left to settle doubts"
    return "\n".join(
        [table(["motion", "for", "time", "why"], rows),
         f"{total:.0f} s of motion in all{most}"]
    )  # fmt: skip


def in_words(found: JsonObject) -> str:
    """How it ended, for the terminal."""
    from pa10d.investigation.words import judged_where, units_of

    if found["status"] != "done":
        why = f": {found['error']}" if found["error"] else ""
        return (
            f"{found['name']} is {found['status']}{why}\n"
            f"go on with: pa10d investigate --resume {found['name']}"
        )
    said = {step["id"]: step["said"] for step in found["steps"]}
    searches = [step for step in found["steps"] if step["kind"] == "diagnose"]
    lines = ["", searches[-1]["said"], *(f"   {r['sentence']}" for r in found["remaining"]),
             said["judge"]]  # fmt: skip
    judged = found["judged"]
    if judged is not None and len(judged["models"]) > 1:
        head = ["joint", "before", "after", "noise floor"]
        columns = zip(judged["before"], judged["after"], judged["noise_floor"], strict=True)
        rows = [
            [str(j), f"{a:.4g}", f"{b:.4g}", "not known" if f is None else f"{f:.4g}"]
            for j, (a, b, f) in enumerate(columns, 1)
        ]
        there = judged_where(
            listed(judged.get("run_names", [])), judged["cutoff_hz"], judged["mask"]
        )
        lines += [
            f"Error in {units_of(judged)} on runs that {judged['seen']} ({there}):",
            table(head, rows),
        ]
    for doubt in found["doubts"]:
        lines.append(doubt["says"])
        lines += [f"   {doubt[key]}" for key in ("plan", "motion") if doubt[key]]
    lines += [f"left out: {why}" for why in found["left_out"]]
    return "\n".join([*lines, f"report: {found['report']}"])


def _copied(found: JsonObject, file: Path) -> None:
    """The report where it was asked for, and beside it what settles the doubts."""
    from pa10d.services.models import write_file

    write_file(file, Path(found["report"]).read_text(encoding="utf-8"))
    found["report"] = str(file)
    for doubt in found["doubts"]:
        for key in ("plan", "motion"):
            if doubt[key]:
                folder = file.parent / "doubts"
                folder.mkdir(exist_ok=True)
                doubt[key] = str(shutil.copy(doubt[key], folder))


def _data(options: argparse.Namespace) -> str:
    from pa10d.store.location import data_folder

    return str(data_folder(options.data))
