"""``pa10d schema``: what the JSON of a command holds."""

from __future__ import annotations

import argparse
import json

from pa10d.cli.answer import VERSION, Answer
from pa10d.cli.commands import Subcommands
from pa10d.common.errors import UserError
from pa10d.common.words import did_you_mean


def add_commands(commands: Subcommands) -> None:
    """``schema``."""
    parser = commands.add(
        "schema",
        schema,
        "the JSON schema of what a command prints with --json",
        examples=(
            "pa10d schema",
            "pa10d schema diagnose",
        ),
    )
    parser.add_argument(
        "name", nargs="?", metavar="NAME", help="such as identify or diagnose; without: all names"
    )


def schema(options: argparse.Namespace) -> Answer:
    """``schema``."""
    from pa10d.services.command_documents import KINDS_OF_DOCUMENT, schema_of

    if options.name is None:
        names = sorted(KINDS_OF_DOCUMENT)
        return Answer({"names": names}, "\n".join(names))
    name = options.name.removeprefix("pa10d/").partition("/")[0]
    if name not in KINDS_OF_DOCUMENT:
        raise UserError(
            f"schema {options.name!r}: expected one of {', '.join(sorted(KINDS_OF_DOCUMENT))}"
            f"{did_you_mean(name, KINDS_OF_DOCUMENT)}"
        )
    found = {"$id": f"pa10d/{name}/{VERSION}", **schema_of(name)}
    return Answer(found, json.dumps(found, indent=2, ensure_ascii=False))
