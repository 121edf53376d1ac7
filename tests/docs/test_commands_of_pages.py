"""Every command of every page is one that the program takes."""

from __future__ import annotations

import re
import shlex

import pytest
from documents import ROOT

from pa10d.cli import families
from pa10d.cli.commands import Subcommands, root_parser

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```\w*\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINES = [
    (page.name, line)
    for page in PAGES
    for block in BLOCK.findall(page.read_text(encoding="utf-8"))
    for line in block.splitlines()
    if line.startswith("pa10d ")
]


@pytest.fixture(scope="module")
def parser():
    parser, subparsers = root_parser()
    commands = Subcommands(subparsers)
    for family in families():
        family.add_commands(commands)
    return parser


@pytest.mark.parametrize(("page", "line"), LINES)
def test_it_is_taken(parser, page, line):
    _, *arguments = shlex.split(line, comments=True)
    assert parser.parse_args(arguments).run


def test_there_are_some():
    assert len(LINES) >= 100
    assert {"profiles.md", "recordings.md", "story.md", "first-power-up.md"} <= {
        p for p, _ in LINES
    }
