"""``pa10d demo``: the whole story on a simulated arm with a hidden effect."""

from __future__ import annotations

import argparse
import secrets
import time
from pathlib import Path
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, table
from pa10d.cli.commands import Subcommands, file_option, profile_option
from pa10d.cli.progress import progress_line
from pa10d.cli.story import end_as_after_interrupt, seed_number, study_folder, tell

if TYPE_CHECKING:
    from pa10d.demo.story import Told


def add_commands(commands: Subcommands) -> None:
    """``demo``."""
    parser = commands.add(
        "demo",
        demo,
        "the whole story on a simulated arm with a hidden effect",
        patient=True,
        examples=(
            "pa10d demo",
            "pa10d demo --hide stribeck:4 --seed 3",
            "pa10d demo --profile arm.yaml",
        ),
    )
    profile_option(parser, remembers=False)
    parser.add_argument(
        "--hide", metavar="EFFECT[:JOINT]",
        help="what the arm hides, or 'none' (default: drawn at random)",
    )  # fmt: skip
    parser.add_argument("--seed", type=seed_number, metavar="N", help="same seed, same story")
    file_option(parser, "report", "the HTML report (default: report.html)", "report.html")


def demo(options: argparse.Namespace) -> Answer:
    """``demo``."""
    from pa10d.demo.bench import Bench
    from pa10d.demo.hidden import hide
    from pa10d.demo.report import write_report
    from pa10d.demo.story import play
    from pa10d.profile import load_profile

    end_as_after_interrupt()
    started = time.monotonic()
    seed = secrets.randbelow(10_000) if options.seed is None else options.seed
    profile = load_profile(options.profile)
    hidden = hide(options.hide, seed, profile)
    bench = Bench(profile, hidden, seed)
    tell("The whole story takes two to five minutes on most machines; Ctrl-C ends it.")
    tell(
        f"1. A simulated {profile.name} and its daemon start, in simulated time, on a bus of their "
        f"own (seed {seed})."
    )
    with study_folder(options.data) as data, bench.running(data):
        told = play(bench, hidden, seed, tell, progress_line())
        report = write_report(told, data, options.report.absolute())
    seconds = time.monotonic() - started
    document = {**told.document(), "report": str(report), "seconds": seconds}
    return Answer(document, in_words(told, report, seconds))


def in_words(told: Told, report: Path, seconds: float) -> str:
    """The end of the story, for the terminal."""
    from pa10d.investigation.words import units_of

    last, known = told.last, told.hidden.in_words()
    labels = [f"{f['effect']} {f['joints'] or ''}".strip() for f in last["findings"]]
    judged = last["judged"]
    columns = zip(judged["before"], judged["after"], judged["noise_floor"], strict=True)
    rows = [
        [str(j), *("not known" if v is None else f"{v:.4g}" for v in row)]
        for j, row in enumerate(columns, 1)
    ]
    return "\n".join(
        [
            f"\nhidden: {known}",
            f"found:  {', '.join(labels) or last['verdict']}",
            "",
            f"Error in {units_of(judged)} on runs that the fit has not seen:",
            table(["joint", "RMS before", "RMS after", "noise floor"], rows),
            *judged.get("left", []),
            "",
            f"{seconds:.0f} s. Report: {report}",
            f"Another arm: pa10d demo. This one again: pa10d demo --seed {told.seed}",
        ]
    )
