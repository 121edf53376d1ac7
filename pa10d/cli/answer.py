"""What a command says: a document for programs, a text for people, notes on stderr."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from typing import Any

from pa10d.cli.streams import give_up, has_all_letters
from pa10d.common.jsonable import plain

VERSION = 1
"""Of the documents: fields may be added under it; one that goes or changes its meaning ends it."""


@dataclass(frozen=True)
class Answer:
    """``document`` is printed with --json, ``text`` without; status 1 says: it did not go well."""

    document: Any
    text: str = ""
    status: int = 0


def note(line: str) -> None:
    """Progress, warnings and the like: never on stdout."""
    print(line, file=sys.stderr, flush=True)


def tagged(kind: str, document: Any) -> Any:
    """The document, or every entry of a list of them, with its kind and version first."""
    if isinstance(document, dict):
        return {"schema": f"pa10d/{kind}/{VERSION}", **document}
    if isinstance(document, list):
        return [tagged(kind, entry) for entry in document]
    return document


def print_answer(answer: Answer, as_json: bool, kind: str = "") -> None:
    """To stdout, in one form or the other; kind: of document, as ``pa10d schema`` knows it."""
    if as_json:
        document = tagged(kind, plain(answer.document)) if kind else plain(answer.document)
        print(_written(document))
    elif answer.text:
        print(answer.text)


def print_failure(message: str, as_json: bool, **more: Any) -> None:
    """Why it could not be done; ``more`` for programs."""
    note(message)
    if as_json:
        try:
            print(_written({"error": message, **more}), flush=True)
        except OSError:  # nor can that be written; it has been said
            give_up(sys.stdout)


def _written(document: Any) -> str:
    letters = has_all_letters(sys.stdout)
    return json.dumps(document, ensure_ascii=not letters, allow_nan=False)


def table(head: list[str], rows: list[list[str]]) -> str:
    """Columns for a person, left-aligned."""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in [head, *rows]
    ]
    return "\n".join(lines)
