"""The report of an investigation: one file that opens without a network, to send on."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.common.version import __version__
from pa10d.common.words import listed
from pa10d.dynamics import Robot
from pa10d.investigation.archive import REPORT, SHEET
from pa10d.investigation.results import LastWord, Searched
from pa10d.investigation.state import Investigation
from pa10d.investigation.words import judged_where, named
from pa10d.report.blocks import Lines, Section, Table, Text
from pa10d.report.facts import Facts, Verdict
from pa10d.report.model_page import Dossier, dossier_sections
from pa10d.report.page import page
from pa10d.report.sheet import Sheet, without_commands
from pa10d.services.dossier import dossier
from pa10d.services.library import Library
from pa10d.services.models import write_file
from pa10d.store.entries import read_entry

LARGEST = 256 << 20  # bytes of a sheet that is read
MARKS = {"done": "done", "left_out": "left out", "waiting": "still to do", "running": "now"}


def write_report(library: Library, place: Path, state: Investigation) -> Path:
    """Into the investigation's folder."""
    return write_file(place / REPORT, report_text(library, place, state))


def report_text(
    library: Library,
    place: Path,
    state: Investigation,
    first: Sequence[Section] = (),
    title: str = "",
) -> str:
    """The page. first: what stands before everything else."""
    found = state.searched
    assert found is not None
    sheet = _dossier(library, state)
    sections = [
        *first,
        Section(
            "In short",
            [Verdict(state.done("diagnose")[-1].said, found.verdict), Facts(_facts(state, found))],
        ),
        *_delivery(state, sheet.model.robot),
        *_doubts(state),
        *map(without_commands, _sheet(place).in_order),
        *dossier_sections(sheet),
        _course(state),
    ]
    question = "what has changed?" if state.question == "changed" else "what is missing?"
    return page(
        title or f"{state.robot}: {question}",
        f"{state.name} · {state.created[:16].replace('T', ' ')} UTC",
        sections,
        f"pa10d {__version__}. SI units, torque at the joint side, joints numbered from 1.",
    )


def _dossier(library: Library, state: Investigation) -> Dossier:
    """What a reviewer asks for: robot, runs, fit, parameters, errors of the last version."""
    fresh = state.recorded("fresh") or state.unseen or state.to_fit
    return dossier(library, state.versions[-1], fresh, searched=state.to_judge)


def _facts(state: Investigation, found: Searched) -> list[tuple[str, str]]:
    frozen = state.question == "changed"
    names = [named(finding, frozen) for finding in found.findings]
    judged = state.done("judge")
    return [
        ("Robot", state.robot),
        ("Asked", "what has changed since" if frozen else "what is missing in its torque model"),
        ("Found", listed(names) or "nothing"),
        ("What it brings", judged[-1].said if judged else ""),
        ("Moved", f"{state.moved:.0f} s" if state.moves else "not moved: recordings alone"),
        ("Left out", " ".join(s.said for s in state.steps
                              if s.status == "left_out" and s.kind == "motion")),
    ]  # fmt: skip


def _delivery(state: Investigation, robot: Robot) -> list[Section]:
    """What was promised, what came of it, and how it holds where nothing was fitted."""
    promise, last = state.delivered, state.last_word
    if promise is None or promise.cutoff_hz is None or last is None:
        return []
    head = ["joint", "as given", "promised", "achieved", f"as given, {_where(last)}",
            "after, there", "noise floor"]  # fmt: skip
    columns = [promise.before, promise.promised, promise.achieved,
               last.before, last.after, last.noise_floor]  # fmt: skip
    rows = [
        [f"{j + 1} {name}", *(_number(None if c is None else c[j]) for c in columns)]
        for j, name in enumerate(robot.joint_names)
    ]
    note = Text(
        f"RMS error in {robot.torque_units()}. Promised and achieved: on the runs that the search "
        f"judged by, low-passed at {promise.cutoff_hz:.4g} Hz. The last columns: on runs that "
        f"{last.seen} ({judged_where(listed(last.run_names), last.cutoff_hz, last.mask)}).",
        muted=True,
    )
    return [Section("Promised and achieved", [Table(head, rows), note])]


def _doubts(state: Investigation) -> list[Section]:
    ways = [finding.settling for finding in state.findings if finding.settling is not None]
    if not ways:
        return []
    lines = []
    for way in ways:
        files = listed([f"doubts/{name}" for name in (way.plan, way.motion) if name])
        text = f"{way.says} It takes {way.seconds:.0f} s; beside this report: {files}."
        lines.append(("", f"{text} {way.problem}".strip()))
    return [Section("What would settle the doubt", [Lines(lines)])]


def _course(state: Investigation) -> Section:
    rows = [
        [step.title, MARKS[step.status], f"{step.moved:.0f} s" if step.moved else "–",
         ", ".join([*step.runs, *step.models]) or "–",
         " ".join([step.said, *step.notes, *step.tuned])]
        for step in state.steps if step.kind != "report"
    ]  # fmt: skip
    return Section("Step by step", [Table(["step", "", "moved", "made", "said"], rows, words=1)])


def _sheet(place: Path) -> Sheet:
    path = place / SHEET / "summary.json"
    text = read_entry(path, LARGEST)
    try:
        return Sheet.read(json.loads(text))
    except (UserError, ValueError) as error:
        raise UserError(f"{path}: {error}; expected the plots of a diagnosis") from error


def _where(judged: LastWord) -> str:
    return "fresh motion" if judged.fresh else "runs to judge by"


def _number(value: float | None) -> str:
    return "not known" if value is None else f"{value:.4g}"
