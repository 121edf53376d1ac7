"""The report of the demo: how the story went, and the pages of the diagnosis that decided it."""

from __future__ import annotations

from pathlib import Path

from pa10d.common.version import __version__
from pa10d.common.words import listed
from pa10d.demo.story import Chapter, Told
from pa10d.demo.words import found_words, named
from pa10d.report.blocks import Section, Table, Text
from pa10d.report.facts import Facts, Verdict
from pa10d.report.page import page
from pa10d.report.sheet import sections_of
from pa10d.services.models import write_file


def write_report(told: Told, robot: str, path: Path) -> Path:
    """One HTML file that opens without a network."""
    kind = "none" if told.right else "missing"
    story = Section(
        "The story",
        [
            Text(
                "A simulated arm was moved by the daemon over CAN and recorded. A textbook model "
                "was fitted to its angles and torques, compared and diagnosed by them alone; "
                "afterwards the simulator told what it had hidden."
            ),
            Facts(_facts(told)),
            Verdict(told.truth, kind),
        ],
    )
    fall = Section("The error on runs that no fit has seen", [_errors(told.last)])
    text = page(
        f"{robot} hides something: what?",
        f"seed {told.seed}",
        [story, fall, *sections_of(told.last.sheet)],
        f"pa10d {__version__}. SI units, torque at the joint side, joints numbered from 1.",
    )
    return write_file(path, text)


def _facts(told: Told) -> list[tuple[str, str]]:
    asked = ("What is missing in the model?", "What has changed since?")
    answers = [(q, found_words(c.found)) for q, c in zip(asked, told.chapters, strict=False)]
    tried = [entry["plan"]["kind"] for chapter in told.chapters for entry in chapter.tried]
    return [
        ("Hidden", told.hidden.in_words()),
        ("Found", listed([named(f) for f in told.last.found["findings"]]) or "nothing"),
        *answers,
        ("Run to settle a doubt", listed(tried)),
        ("To see it again", f"pa10d demo --seed {told.seed}"),
    ]


def _errors(chapter: Chapter) -> Table:
    rows = [
        [str(j + 1), f"{before:.4g}", f"{after:.4g}"]
        for j, (before, after) in enumerate(zip(chapter.before, chapter.after, strict=True))
    ]
    return Table(["joint", "RMS before, N·m", "RMS after, N·m"], rows)
