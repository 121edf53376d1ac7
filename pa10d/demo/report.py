"""The report of the demo: how the story went, and the investigation that decided it."""

from __future__ import annotations

from pathlib import Path

from pa10d.common.jsonable import parsed
from pa10d.common.words import listed
from pa10d.demo.story import Told, answered, settling
from pa10d.investigation.archive import Archive
from pa10d.investigation.report import report_text
from pa10d.investigation.results import Searched
from pa10d.investigation.words import named
from pa10d.report.blocks import Section, Text
from pa10d.report.facts import Facts, Verdict
from pa10d.services.library import open_library
from pa10d.services.models import write_file


def write_report(told: Told, data: Path, path: Path) -> Path:
    """One HTML file that opens without a network. data: where the story's investigations are."""
    archive = Archive(data)
    state = archive.load(told.last["id"])
    title = f"{state.robot} hides something: what?"
    text = report_text(
        open_library(data), archive.place(state.id), state, first=(_story(told),), title=title
    )
    return write_file(path, text)


def _story(told: Told) -> Section:
    return Section(
        "The story",
        [
            Text(
                "A simulated arm was moved by the daemon over CAN and recorded. A textbook model "
                "was fitted to its angles and torques, compared and diagnosed by them alone; "
                "afterwards the simulator told what it had hidden."
            ),
            Facts(_facts(told)),
            Verdict(told.truth, "none" if told.right else "missing"),
        ],
    )


def _facts(told: Told) -> list[tuple[str, str]]:
    asked = ("What is missing in the model?", "What has changed since?")
    found = [parsed(Searched, chapter) for chapter in told.chapters]
    answers = [(q, answered(one)) for q, one in zip(asked, told.chapters, strict=False)]
    tried = [step["experiment"]["kind"] for chapter in told.chapters for step in settling(chapter)]
    return [
        ("Hidden", told.hidden.in_words()),
        ("Found", listed([named(f) for f in found[-1].findings]) or "nothing"),
        *answers,
        ("Run to settle a doubt", listed(tried)),
        ("To see it again", f"pa10d demo --seed {told.seed}"),
    ]
