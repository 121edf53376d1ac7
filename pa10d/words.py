"""Numbers and lists as a sentence has them."""

from __future__ import annotations

from collections.abc import Sequence


def percent(share: float) -> str:
    """``38 %``; nothing is ever gone to 100 %."""
    return "more than 99 %" if share > 0.99 else f"{100 * share:.0f} %"


def listed(words: Sequence[str], last: str = "and") -> str:
    """``a, b and c``."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"
