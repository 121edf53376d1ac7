"""``pa10d demo``: the whole story on a simulated arm with a hidden effect."""

from __future__ import annotations

import argparse
import contextlib
import secrets
import signal
import tempfile
import textwrap
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import Commands, profile_option
from pa10d.cli.daemon_client import progress_line

if TYPE_CHECKING:
    from pa10d.demo.story import Told

WIDTH = 92


def add_commands(commands: Commands) -> None:
    """``demo``."""
    parser = commands.add("demo", demo, "the whole story on a simulated arm with a hidden effect")
    profile_option(parser)
    parser.add_argument(
        "--hide", metavar="EFFECT[:JOINT]",
        help="what the arm hides, or 'none' (default: drawn at random)",
    )  # fmt: skip
    parser.add_argument("--seed", type=_seed, metavar="N", help="same seed, same story")
    parser.add_argument(
        "--report", type=Path, default=Path("report.html"), metavar="FILE",
        help="the HTML report (default: report.html)",
    )  # fmt: skip


def demo(options: argparse.Namespace) -> Answer:
    """``demo``."""
    from pa10d.demo.bench import Bench
    from pa10d.demo.hidden import hide
    from pa10d.demo.report import write_report
    from pa10d.demo.story import play
    from pa10d.profile import load_profile

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # ends as after Ctrl-C
    started = time.monotonic()
    seed = secrets.randbelow(10_000) if options.seed is None else options.seed
    profile = load_profile(options.profile)
    hidden = hide(options.hide, seed, profile)
    bench = Bench(profile, hidden, seed)
    _tell(
        f"1. A simulated {profile.name} and its daemon start, on a bus of their own (seed {seed})."
    )
    with _data(options.data) as data, bench.running(data):
        told = play(bench, hidden, seed, _tell, progress_line())
    report = write_report(told, profile.name, options.report.absolute())
    seconds = time.monotonic() - started
    document = {**told.document(), "report": str(report), "seconds": seconds}
    return Answer(document, in_words(told, report, seconds))


def in_words(told: Told, report: Path, seconds: float) -> str:
    """The end of the story, for the terminal."""
    last, known = told.last, told.hidden.in_words()
    labels = [f"{f['effect']} {f['joints'] or ''}".strip() for f in last.found["findings"]]
    columns = zip(last.before, last.after, last.found["noise_floor"], strict=True)
    rows = [[str(j), *(f"{v:.4g}" for v in row)] for j, row in enumerate(columns, 1)]
    return "\n".join(
        [
            f"\nhidden: {known}",
            f"found:  {', '.join(labels) or last.found['verdict']}",
            "",
            "Error in N·m on runs that the fit has not seen:",
            table(["joint", "RMS before", "RMS after", "noise floor"], rows),
            "",
            f"{seconds:.0f} s. Report: {report}",
            f"Another arm: pa10d demo. This one again: pa10d demo --seed {told.seed}",
        ]
    )


def _tell(words: str) -> None:
    note(textwrap.fill(words, WIDTH, subsequent_indent="   ", break_long_words=False))


@contextlib.contextmanager
def _data(given: str | None) -> Iterator[Path]:
    """The folder that was asked for, or one that is gone afterwards."""
    if given is not None:
        yield Path(given)
        return
    with tempfile.TemporaryDirectory(prefix="pa10d-demo-") as folder:
        yield Path(folder)


def _seed(text: str) -> int:
    if not text.isdigit():
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a whole number from 0")
    return int(text)
