"""Physical effects beyond the rigid bodies: one small class each, and their registry."""

from pa10d.common.callable_room import answer_calls
from pa10d.effects.base import (
    Coefficient,
    Effect,
    Example,
    Shape,
    ShapeParameter,
    Value,
    View,
    smooth_sign,
)
from pa10d.effects.context import Context
from pa10d.effects.memory import fading
from pa10d.effects.registry import all_effects, effect

__all__ = [
    "Coefficient",
    "Context",
    "Effect",
    "Example",
    "Shape",
    "ShapeParameter",
    "Value",
    "View",
    "all_effects",
    "effect",
    "fading",
    "smooth_sign",
]

answer_calls(__name__, "pa10d.face.effects:effects")
