"""Names of unknowns where an effect stands in a model twice: as it was, and what has changed."""

from __future__ import annotations

from collections.abc import Sequence

AGAIN = ", again"


def told_apart(names: Sequence[str]) -> list[str]:
    """The same names, each that stands there before with what tells it from that one."""
    return [f"{name}{AGAIN}" if name in names[:k] else name for k, name in enumerate(names)]
