"""How commands are declared."""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pa10d.cli.answer import Answer
from pa10d.cli.parser import Parser
from pa10d.common.errors import UserError
from pa10d.common.version import __version__

DEFAULT_PROFILE = "pa10-sim"
FIRST_STEPS = (
    "pa10d demo",
    "pa10d run import train.csv --profile robot.urdf --name train",
    "pa10d identify train --profile robot.urdf --name m0",
    "pa10d diagnose m0 --fit train",
    "pa10d COMMAND --help",
)
Run = Callable[[argparse.Namespace], Answer]


@dataclass
class Current:
    """The command that runs. patient: it has processes to end in order when interrupted."""

    patient: bool = False


current = Current()


class WrongUsage(UserError):
    """Words that cannot be carried out whatever the data are, as a misspelt option: status 2."""


def root_parser() -> tuple[Parser, Any]:
    """The parser of ``pa10d`` and the place where commands hang."""
    parser = Parser(
        prog="pa10d",
        description="Hold a robot arm by its amplifiers and learn what its torque is made of.",
        parents=[_anywhere()],
        examples=FIRST_STEPS,
    )
    parser.add_argument("--version", action="version", version=f"pa10d {__version__}")
    return parser, parser.add_subparsers(metavar="COMMAND", required=True)


class Subcommands:
    """Where a family adds its commands; ``group`` is a command with commands of its own."""

    def __init__(self, subparsers: Any, within: str = "") -> None:
        """within: the command that these belong to."""
        self._subparsers, self._within = subparsers, within

    def add(
        self, name: str, run: Run, says: str, *, examples: Sequence[str], patient: bool = False
    ) -> Parser:
        """A command: ``run(options)`` gives its Answer. The caller adds options to the parser.

        examples: whole command lines, shown by its --help.
        patient: interrupted, it ends what it started in good order; others end at once."""
        parser = self._parser(name, says, examples)
        parser.set_defaults(
            run=run, patient=patient, answers=f"{self._within}{name}", parser=parser,
            takes_profile=False, remembers=False, writes=[],
        )  # fmt: skip
        return parser

    def group(self, name: str, says: str) -> Subcommands:
        """A command with commands of its own, such as ``pa10d run import``."""
        parser = self._parser(name, says, ())
        return Subcommands(parser.add_subparsers(metavar="COMMAND", required=True), f"{name}-")

    def _parser(self, name: str, says: str, examples: Sequence[str]) -> Parser:
        parser: Parser = self._subparsers.add_parser(
            name, help=says, description=says, parents=[_anywhere()], examples=examples
        )
        return parser


def profile_option(parser: argparse.ArgumentParser, *, remembers: bool = True) -> None:
    """--profile P; remembers: without it, the one that was last used with the data."""
    default = f"the one last used with this data, else {DEFAULT_PROFILE}"
    parser.set_defaults(takes_profile=True, remembers=remembers)
    parser.add_argument(
        "--profile",
        metavar="P",
        help="the robot: a profile's name or YAML file, or a URDF file "
        f"(default: {default if remembers else DEFAULT_PROFILE})",
    )


def file_option(parser: argparse.ArgumentParser, name: str, says: str, default: str = "") -> None:
    """--name FILE, written at the end: that it can be is looked at before anything begins."""
    parser.get_default("writes").append(name)
    parser.add_argument(
        f"--{name}",
        type=Path,
        default=Path(default) if default else None,
        metavar="FILE",
        help=says,
    )


def refuse_unwritable(options: argparse.Namespace) -> None:
    """A file that could not be written in the end is told before the work."""
    for name in options.writes:
        path = getattr(options, name)
        if path is None:
            continue
        folder = path.absolute().parent
        if not folder.is_dir():
            raise UserError(f"--{name} {path}: no such folder; expected one that exists")
        if path.is_dir() or not os.access(path if path.exists() else folder, os.W_OK):
            raise UserError(f"--{name} {path}: expected a file that can be written")


def whole_number(least: int, most: int) -> Callable[[str], int]:
    """Of an option: from ``least`` to ``most``."""

    def read(text: str) -> int:
        if not text.isascii() or not text.isdecimal() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(
                f"found {text!r}, expected a whole number from {least} to {most}"
            )
        return int(text)

    return read


def positive(text: str) -> float:
    """Of an option: a finite number above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a number above 0")
    return value


def replace_option(parser: argparse.ArgumentParser, what: str) -> None:
    """--replace."""
    parser.add_argument("--replace", action="store_true", help=f"take the place of {what}")


def force_option(parser: argparse.ArgumentParser) -> None:
    """--force."""
    parser.add_argument(
        "--force", action="store_true",
        help="use recordings that the checks have an error against, too",
    )  # fmt: skip


def _anywhere() -> argparse.ArgumentParser:
    """Options that are taken before and after the command, whichever way."""
    parser = Parser(add_help=False)
    parser.add_argument(
        "--data",
        metavar="DIR",
        default=argparse.SUPPRESS,
        help="where runs and models are kept (default: PA10D_DATA or the user's data folder)",
    )
    parser.add_argument(
        "--json",
        action="store_true",
        default=argparse.SUPPRESS,
        help="print one JSON document on stdout and nothing else",
    )
    return parser
