"""``pa10d completion SHELL``: the tab key knows commands, options and the names in the data."""

from __future__ import annotations

import argparse
import json
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pa10d.cli.answer import Answer
from pa10d.cli.commands import Subcommands
from pa10d.cli.parser import Parser

SHELLS = ("bash", "zsh", "fish")
HEAD = 4096  # bytes of a model's file that hold its name


def add_commands(commands: Subcommands) -> None:
    """``completion``."""
    parser = commands.add(
        "completion", completion, "what makes the tab key complete pa10d's words",
        examples=('eval "$(pa10d completion bash)"', "pa10d completion fish | source"),
    )  # fmt: skip
    parser.add_argument("shell", choices=SHELLS)


def completion(options: argparse.Namespace) -> Answer:
    """``completion``."""
    import argcomplete

    code = argcomplete.shellcode(["pa10d"], shell=options.shell)
    return Answer({"shell": options.shell, "code": code}, code.strip())


def complete(parser: Parser) -> None:
    """Answer the shell and end the process, where it is the shell that asks."""
    if "_ARGCOMPLETE" not in os.environ:
        return
    import argcomplete

    _name_completers(parser)
    argcomplete.autocomplete(parser)


def _name_completers(parser: argparse.ArgumentParser) -> None:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                _name_completers(below)
        elif action.metavar in _KNOWN:
            action.completer = _KNOWN[action.metavar]  # type: ignore[attr-defined]


def _runs(parsed_args: argparse.Namespace, **_: Any) -> list[str]:
    """Read here and not by the store, which repairs what it opens: a key was pressed, no more."""
    found = []
    for file in (_data(parsed_args) / "runs").glob("*/run.json"):
        try:
            found.append(str(json.loads(file.read_bytes())["name"]))
        except (OSError, ValueError, KeyError, TypeError):
            continue  # the store says what is wrong with it
    return found


def _models(parsed_args: argparse.Namespace, **_: Any) -> list[str]:
    found = []
    for file in (_data(parsed_args) / "models").glob("*.yaml"):
        with file.open("rb") as opened:
            head = opened.read(HEAD).decode(errors="replace")
        found += re.findall(r"^name: (\S+)$", head, re.MULTILINE)[:1]
    return found


def _profiles(prefix: str, **_: Any) -> list[str]:
    from argcomplete.completers import FilesCompleter

    from pa10d.profile.load import profile_folders

    shipped = [path.stem for folder in profile_folders() for path in folder.glob("*.yaml")]
    return [*shipped, *FilesCompleter(("yaml", "urdf"))(prefix)]


def _effects(**_: Any) -> list[str]:
    from pa10d.effects import all_effects

    return list(all_effects())


def _data(options: argparse.Namespace) -> Path:
    from pa10d.store.location import data_folder

    return data_folder(getattr(options, "data", None))


_KNOWN: dict[Any, Callable[..., list[str]]] = {
    "RUN": _runs, "MODEL": _models, "P": _profiles, "EFFECT": _effects, "E": _effects,
    "ID": _effects,
}  # fmt: skip
