"""Kinds of values that files written by people contain, checked as they are read."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from pa10d.common.yamlfile import expected

NARROWEST = 1e-3  # rad (m) in which a joint may move at all


def _count(n: int) -> BeforeValidator:
    def check(value: Any) -> Any:
        if not isinstance(value, list | tuple) or len(value) != n:
            raise expected(f"a list of {n} numbers")
        return value

    return BeforeValidator(check)


def _ascending(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] >= pair[1]:
        raise expected("lower and upper limit, the lower one first")
    return pair


def _roomy(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[1] - pair[0] < NARROWEST:
        raise expected(f"limits that are at least {NARROWEST:g} apart")
    return pair


def _nonzero(value: float) -> float:
    if value == 0:
        raise expected("a number other than 0")
    return value


def _height(value: Any) -> Any:
    """A number, or none (which YAML reads as a word, and null as nothing)."""
    if value is None or value == "none":
        return "none"
    if isinstance(value, bool) or not isinstance(value, int | float) or not -1e3 < value < 1e3:
        raise expected("a height in m, or none")
    return float(value)


def _in_rad(value: float) -> float:
    if abs(value) > 2.0 * math.pi:
        raise expected("an angle in rad, of one turn at most")
    return value


def _lengths(value: tuple[float, ...]) -> tuple[float, ...]:
    if min(value) <= 0:
        raise expected("three lengths in m, all above 0")
    return value


def _physical_inertia(value: tuple[float, ...]) -> tuple[float, ...]:
    """Ixx … of a rigid body about its centre of mass: every second moment is at least 0."""
    import numpy as np

    xx, yy, zz, xy, xz, yz = value
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    second_moments = np.eye(3) * np.trace(tensor) / 2 - tensor
    if np.linalg.eigvalsh(second_moments)[0] < -1e-9 * max(1e-12, float(np.abs(tensor).max())):
        raise expected("Ixx Iyy Izz Ixy Ixz Iyz of a body that can exist (triangle inequality)")
    return value


def at_least(low: float) -> AfterValidator:
    """Of what is above nothing, but too little for any arm."""

    def check(value: float) -> float:
        if value < low:
            raise expected(f"a number of at least {low:g}")
        return value

    return AfterValidator(check)


def _factory(value: str) -> str:
    module, _, function = value.partition(":")
    if not function.isidentifier() or not all(p.isidentifier() for p in module.split(".")):
        raise expected("'package.module:factory'")
    return value


Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Nonzero = Annotated[Number, AfterValidator(_nonzero)]
Text = Annotated[str, Field(strict=True, min_length=1)]
Factory = Annotated[Text, AfterValidator(_factory)]
Vector3 = Annotated[tuple[Number, Number, Number], _count(3)]
Turned = Annotated[Number, AfterValidator(_in_rad)]
Turns3 = Annotated[tuple[Turned, Turned, Turned], _count(3)]
Size = Annotated[tuple[Number, Number, Number], AfterValidator(_lengths), _count(3)]
Height = Annotated[float | Literal["none"], BeforeValidator(_height)]
Range = Annotated[
    tuple[Number, Number], AfterValidator(_ascending), AfterValidator(_roomy), _count(2)
]
Inertia = Annotated[
    tuple[Number, Number, Number, Number, Number, Number],
    AfterValidator(_physical_inertia),
    _count(6),
]


class Counted:
    """How many entries a list was found to have, as a message shows it."""

    def __init__(self, count: int) -> None:
        self.count = count

    def __repr__(self) -> str:
        return f"{self.count} {'entry' if self.count == 1 else 'entries'}"
