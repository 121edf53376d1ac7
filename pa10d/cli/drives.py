"""``pa10d drives …``: what the drives themselves remember."""

from __future__ import annotations

import argparse

from pa10d.cli.answer import Answer, table
from pa10d.cli.commands import Subcommands
from pa10d.cli.daemon_client import robot_options
from pa10d.common.jsonable import JsonObject


def add_commands(commands: Subcommands) -> None:
    """The family ``drives``."""
    drives = commands.group(
        "drives", "errors, clear: what drives remember; confirm: where joints stand"
    )
    looking = drives.add(
        "errors",
        errors,
        "what each drive remembers of its errors, newest first",
        patient=True,
        examples=("pa10d drives errors", "pa10d drives errors --profile arm.yaml --json"),
    )
    robot_options(looking)
    clearing = drives.add(
        "clear",
        clear,
        "empty the drives' histories of errors; a fault is acknowledged by 'reset', not by this",
        patient=True,
        examples=("pa10d drives clear",),
    )
    robot_options(clearing)
    confirming = drives.add(
        "confirm",
        confirm,
        "somebody has looked: every joint stands where its drive says, after one read elsewhere",
        patient=True,
        examples=("pa10d drives confirm",),
    )
    robot_options(confirming)


def errors(options: argparse.Namespace) -> Answer:
    """``drives errors``: by the daemon that runs on this data, else by one of our own."""
    return _asked(options, clear=False)


def clear(options: argparse.Namespace) -> Answer:
    """``drives clear``."""
    return _asked(options, clear=True)


def confirm(options: argparse.Namespace) -> Answer:
    """``drives confirm``."""
    from pa10d.cli.daemon_client import daemon_for

    with daemon_for(options) as client:
        doubted = client.wait_for_robot("inactive")["misplaced"]
        left = client.confirm()["misplaced"] if doubted else []
    lines = [f"{one['sentence']}: believed" for one in doubted if one not in left]
    words = "\n".join(lines) or "every joint stands where it stood: nothing to confirm"
    return Answer({"confirmed": doubted, "left": left}, words, status=1 if left else 0)


def _asked(options: argparse.Namespace, clear: bool) -> Answer:
    from pa10d.cli.daemon_client import daemon_for

    with daemon_for(options) as client:
        found = client.drive_errors(clear=clear)
    failed = any(one["problem"] for one in found)
    return Answer({"drives": found}, in_words(found), status=1 if failed else 0)


def in_words(found: list[JsonObject]) -> str:
    """A row for every drive, and one more for each error before the newest."""
    rows = []
    for one in found:
        history = [entry["words"] + _of_the_maker(entry) for entry in one["history"] or []]
        first = history[0] if history else "none" if one["history"] == [] else "keeps none"
        now = one["error"]["words"] if one["error"] else ", ".join(one["wrong_now"]) or "none"
        if one["problem"]:
            rows.append([f"{one['joint']} {one['name']}", "?", one["problem"]])
        else:
            rows.append([f"{one['joint']} {one['name']}", now, first])
        rows += [["", "", words] for words in history[1:]]
    return table(["joint", "error now", "remembered, newest first"], rows)


def _of_the_maker(entry: JsonObject) -> str:
    more = entry["of_the_maker"]
    return f", maker's own 0x{more:04X}" if more else ""
