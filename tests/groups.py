"""Which files a group of tests can lie in, by their text: who asks for a few reads no others."""

from __future__ import annotations

from pathlib import Path

import pytest

GROUPS = ("alone", "browser", "realtime")


def asked_for(expression: str) -> list[str]:
    """Groups that every test of an expression for ``-m`` is in; none where it has alternatives."""
    words = expression.split()
    if "or" in words or "(" in expression:
        return []
    pairs = zip(["", *words], words, strict=False)
    return [word for before, word in pairs if word in GROUPS and before != "not"]


def may_be_in(file: Path, group: str) -> bool:
    """Whether the file, or the conftest beside it, has the marker."""
    texts = (path for path in (file, file.parent / "conftest.py") if path.is_file())
    return any(f"mark.{group}" in path.read_text(encoding="utf-8") for path in texts)


def pytest_ignore_collect(collection_path, config):
    """Most of what collecting takes is imports: a group of a few files leaves the others alone."""
    if not (collection_path.name.startswith("test_") and collection_path.suffix == ".py"):
        return None
    wanted = asked_for(config.option.markexpr)
    return None if all(may_be_in(collection_path, group) for group in wanted) else True


def pytest_collection_modifyitems(items):
    """What the texts do not tell is no part of a group."""
    for item in items:
        for group in GROUPS:
            if group in item.keywords and not may_be_in(item.path, group):
                raise pytest.UsageError(
                    f"{item.nodeid} is marked {group} by neither its file nor the conftest beside "
                    "it: those who ask for that group would not see it"
                )
