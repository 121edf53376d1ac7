"""How a unit changes when time is counted otherwise: the power of the second in it."""

from __future__ import annotations

import re
from collections.abc import Mapping

SECONDS = {
    "N": -2.0, "W": -3.0, "J": -2.0, "Hz": -1.0, "s": 1.0,
    **dict.fromkeys(("m", "rad", "kg", "rev", "cycles", "K", "°C", "1"), 0.0),
}  # fmt: skip
TOKEN = re.compile(r"°?[A-Za-z]+|\d+|[()·/^²³]|\s+")


def power_of_second(unit: str, shape: Mapping[str, float]) -> float:
    """Of ``N·m·(s/rad)^p`` and the like, p a shape parameter; ValueError where it is no unit."""
    tokens = [t for t in TOKEN.findall(unit) if t.strip()]
    if "".join(tokens) != unit.replace(" ", ""):
        raise ValueError(f"unit {unit!r}: cannot be read")
    value, rest = _product(tokens, shape, unit)
    if rest:
        raise ValueError(f"unit {unit!r}: cannot be read from {rest[0]!r} on")
    return value


def _product(tokens: list[str], shape: Mapping[str, float], unit: str) -> tuple[float, list[str]]:
    total, sign = 0.0, 1.0
    while tokens:
        one, tokens = _factor(tokens, shape, unit)
        total += sign * one
        if not tokens or tokens[0] not in ("·", "/"):
            break
        sign = 1.0 if tokens[0] == "·" else -1.0
        tokens = tokens[1:]
        if not tokens:
            raise ValueError(f"unit {unit!r}: nothing follows its last sign")
    return total, tokens


def _factor(tokens: list[str], shape: Mapping[str, float], unit: str) -> tuple[float, list[str]]:
    head, tokens = tokens[0], tokens[1:]
    if head == "(":
        value, tokens = _product(tokens, shape, unit)
        if not tokens or tokens[0] != ")":
            raise ValueError(f"unit {unit!r}: a bracket stays open")
        tokens = tokens[1:]
    elif head in SECONDS:
        value = SECONDS[head]
    else:
        raise ValueError(f"unit {unit!r}: {head!r} is not known")
    if tokens and tokens[0] in ("²", "³"):
        return value * (2.0 if tokens[0] == "²" else 3.0), tokens[1:]
    if len(tokens) > 1 and tokens[0] == "^":
        power = shape[tokens[1]] if tokens[1] in shape else float(tokens[1])
        return value * power, tokens[2:]
    return value, tokens
