"""How exports name what they leave out, and what people wrote within comments."""

from __future__ import annotations

import re
from collections.abc import Sequence

from pa10d.model import Term


def grouped(terms: Sequence[Term]) -> list[str]:
    """``rotor_inertia of joints 1, 2, 3``: one entry per effect."""
    joints: dict[str, list[int]] = {}
    for term in terms:
        joints.setdefault(term.effect_id, []).extend(j + 1 for j in term.joints)
    return [
        name if not found else f"{name} of joint{'s' if len(found) > 1 else ''} {_listed(found)}"
        for name, found in joints.items()
    ]


def in_comment(text: str) -> str:
    """As an XML comment may hold it: no two hyphens in a row, none at the end."""
    return re.sub(r"-(?=-|$)", "- ", text)


def _listed(numbers: list[int]) -> str:
    return ", ".join(map(str, sorted(numbers)))
