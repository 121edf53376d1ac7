"""How exports name what they leave out."""

from __future__ import annotations

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


def _listed(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers))
