"""Lists in pages: the cursor is the id of the last item seen, so that new items disturb nothing."""

from __future__ import annotations

from typing import Any


def page_of(items: list[dict[str, Any]], limit: int, cursor: str | None) -> dict[str, Any]:
    """``items`` newest first, with falling ids; those after ``cursor``, at most ``limit``."""
    rest = items if cursor is None else [item for item in items if item["id"] < cursor]
    shown = rest[:limit]
    more = len(rest) > len(shown)
    return {
        "total": len(items),
        "items": shown,
        "next": shown[-1]["id"] if more and shown else None,
    }
