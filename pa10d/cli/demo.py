"""``pa10d demo``: the whole story on a simulated arm with a hidden effect."""

from __future__ import annotations

import argparse
import contextlib
import secrets
import tempfile
import textwrap
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import Commands, profile_option

if TYPE_CHECKING:
    from pa10d.services.demo import Told


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
    from pa10d.services.demo import play
    from pa10d.services.library import open_library

    started = time.monotonic()
    seed = secrets.randbelow(10_000) if options.seed is None else options.seed
    with _data(options.data) as data:
        told = play(
            open_library(data), options.profile, asked=options.hide, seed=seed,
            report=options.report.absolute(), tell=_tell, progress=Slowly(),
        )  # fmt: skip
    seconds = time.monotonic() - started
    return Answer({**told.document(), "seconds": seconds}, in_words(told, seconds))


def in_words(told: Told, seconds: float) -> str:
    """The end of the story, for the terminal."""
    found = told.diagnosis
    labels = [finding.term.label for finding in found.findings]
    last = found.versions[-1].held_out["held out"]
    rows = [
        [str(j + 1), f"{found.rms[j]:.4g}", f"{last[j]:.4g}", f"{found.noise_floor[j]:.4g}"]
        for j in range(len(last))
    ]
    head = ["joint", "RMS before", "RMS after", "noise floor"]
    return "\n".join(
        [
            f"\nhidden: {told.hidden.in_words()}",
            f"found:  {', '.join(labels) or found.verdict}",
            "",
            "Error in N·m on runs that the fit has not seen:",
            table(head, rows),
            "",
            f"{seconds:.0f} s. Report: {told.report}",
            f"Another arm: pa10d demo. This one again: pa10d demo --seed {told.seed}",
        ]
    )


def _tell(words: str) -> None:
    note(textwrap.fill(words, WIDTH, subsequent_indent="   ", break_long_words=False))


class Slowly:
    """Progress on stderr, a line every few seconds."""

    EVERY = 3.0  # s

    def __init__(self) -> None:
        self._last = time.monotonic()

    def __call__(self, share: float, what: str) -> None:
        now = time.monotonic()
        if now - self._last >= self.EVERY:
            self._last = now
            note(f"   {share:4.0%}  {what}")


@contextlib.contextmanager
def _data(given: str | None) -> Iterator[str]:
    """The folder that was asked for, or one that is gone afterwards."""
    if given is not None:
        yield given
        return
    with tempfile.TemporaryDirectory(prefix="pa10d-demo-") as folder:
        yield folder


def _seed(text: str) -> int:
    if not text.isdigit():
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a whole number from 0")
    return int(text)
