"""Every command of these pages is one that the program takes."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from pa10d.cli import families
from pa10d.cli.commands import Subcommands, root_parser

DOCS = Path(__file__).parents[2] / "docs"
PAGES = ("investigate.md", "scale.md", "controllers.md")
TEXT = "".join((DOCS / name).read_text(encoding="utf-8") for name in PAGES)
BLOCKS = re.findall(r"```sh\n(.*?)```", TEXT, re.DOTALL)
LINES = [line for block in BLOCKS for line in block.splitlines() if line]


@pytest.mark.parametrize("line", LINES)
def test_it_is_taken(line):
    parser, subparsers = root_parser()
    commands = Subcommands(subparsers)
    for family in families():
        family.add_commands(commands)
    program, *arguments = shlex.split(line)
    assert program == "pa10d"
    assert parser.parse_args(arguments).run


def test_there_are_some():
    assert len(LINES) >= 17
