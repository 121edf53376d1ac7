"""Which files a group of tests can lie in, by their text: who asks for a few reads no others."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

GROUPS = ("alone", "browser", "realtime")


def asked_for(expression: str) -> list[str]:
    """Groups that every test of an expression for ``-m`` is in; none where it has alternatives."""
    return [group for group, inside in _named(expression) if inside]


def left_out(expression: str) -> list[str]:
    """Groups that no test of the expression is in."""
    return [group for group, inside in _named(expression) if not inside]


def _named(expression: str) -> list[tuple[str, bool]]:
    words = expression.split()
    if "or" in words or "(" in expression:
        return []
    pairs = zip(["", *words], words, strict=False)
    return [(word, before != "not") for before, word in pairs if word in GROUPS]


def may_be_in(file: Path, group: str) -> bool:
    """Whether the file, or the conftest beside it, has the marker."""
    texts = (path for path in (file, file.parent / "conftest.py") if path.is_file())
    return any(f"mark.{group}" in path.read_text(encoding="utf-8") for path in texts)


def is_wholly_in(file: Path, group: str) -> bool:
    """Whether all tests of the file have the marker: by its own ``pytestmark``, or by the conftest
    beside it, which gives it to each."""
    beside = file.parent / "conftest.py"
    given = beside.is_file() and f"add_marker(pytest.mark.{group})" in beside.read_text("utf-8")
    own = rf"^pytestmark = .*\bmark\.{group}\b"
    return given or re.search(own, file.read_text("utf-8"), re.MULTILINE) is not None


def pytest_ignore_collect(collection_path, config):
    """Most of what collecting takes is imports: a group of a few files leaves the others alone."""
    if not (collection_path.name.startswith("test_") and collection_path.suffix == ".py"):
        return None
    expression = config.option.markexpr
    if not all(may_be_in(collection_path, group) for group in asked_for(expression)):
        return True
    none_of = left_out(expression)
    return True if any(is_wholly_in(collection_path, group) for group in none_of) else None


def pytest_collection_modifyitems(items):
    """What the texts do not tell is no part of a group."""
    for item in items:
        for group in GROUPS:
            if group in item.keywords and not may_be_in(item.path, group):
                raise pytest.UsageError(
                    f"{item.nodeid} is marked {group} by neither its file nor the conftest beside "
                    "it: those who ask for that group would not see it"
                )
