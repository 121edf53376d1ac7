"""Lists in pages: the cursor is the id of the last item seen, so that new items disturb nothing."""

from __future__ import annotations

from pa10d.common.jsonable import JsonObject


def page_of(items: list[JsonObject], limit: int, cursor: str | None) -> JsonObject:
    """``items`` newest first, with falling ids; those after ``cursor``, at most ``limit``."""
    rest = items if cursor is None else [item for item in items if item["id"] < cursor]
    shown = rest[:limit]
    more = len(rest) > len(shown)
    return {
        "total": len(items),
        "items": shown,
        "next": shown[-1]["id"] if more and shown else None,
    }
