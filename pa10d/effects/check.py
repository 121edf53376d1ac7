"""Is this a whole effect? Said in one line, for effects that come from elsewhere."""

from __future__ import annotations

from pa10d.effects.base import Coefficient, Effect, ShapeParameter

TEXTS = ("id", "title", "equation", "signature", "experiment", "source")
CHOICES = {
    "scope": ("joint", "pair", "robot"),
    "question": ("textbook", "missing", "changed"),
}


def fault(found: object) -> str | None:
    """What is wrong with an effect, or None: ``'source' is missing, expected a text``."""
    if not isinstance(found, Effect):
        kind = found.__name__ if isinstance(found, type) else type(found).__name__
        return f"{kind} is no subclass of pa10d.effects.Effect"
    for name in TEXTS:
        text = getattr(found, name, None)
        if not isinstance(text, str) or not text.strip():
            return _wrong(found, name, "a text")
    if not found.id.isidentifier() or not found.id.islower():
        return f"id {found.id!r}, expected small letters, digits and underscores"
    for name, allowed in CHOICES.items():
        if getattr(found, name) not in allowed:
            return _wrong(found, name, f"one of {', '.join(allowed)}")
    linear = getattr(found, "coefficients", ())
    if not linear or not all(isinstance(c, Coefficient) for c in linear):
        return _wrong(found, "coefficients", "at least one Coefficient")
    if not all(isinstance(s, ShapeParameter) for s in found.shapes):
        return _wrong(found, "shapes", "ShapeParameters")
    if found.scope != "joint" and not found.reaches_other_joints:
        return f"a {found.scope} effect needs reaches_other_joints = True and (N, n, k) columns"
    if found.shapes and type(found).starts is Effect.starts:
        return "it has shape parameters, so expected a method 'starts' that gives values for them"
    return None


def _wrong(found: Effect, name: str, expected: str) -> str:
    missing = object()
    value = getattr(found, name, missing)
    told = "is missing" if value is missing else f"is {value!r}"
    return f"{name!r} {told}, expected {expected}"
