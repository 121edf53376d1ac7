"""Regions and curves in words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.compare.curves import Curve
from pa10d.compare.quantities import Quantity
from pa10d.compare.regions import Region

NEGLIGIBLE = 1e-6  # of a range's other end: the rounding of a zero
MOST_DIGITS = 6  # of a range's ends, where fewer are the same


def sentence(
    joint: int, what: Region | Curve, torque_unit: str, whose: str = "its squared error"
) -> str:
    """``Joint 4 below 0.2 rad/s carries 61 % of its squared error (in 12 % of its samples)``."""
    if isinstance(what, Region):
        return (
            f"Joint {joint + 1} {_range(joint, what)} carries {what.share:.0%} of {whose} "
            f"(in {what.samples:.0%} of its samples)".replace("%", " %")
        )
    share = f"{what.share:.0%}".replace("%", " %")
    if what.quantity is None:
        return (
            f"Joint {joint + 1} is off by a constant {what.level:+.2g} {torque_unit}, "
            f"which is {share} of {whose}"
        )
    return (
        f"Joint {joint + 1}'s error follows {_words(joint, what.quantity)}: "
        f"a fixed curve against it explains {share} of {whose}"
    )


def brief(joint: int, what: Region | Curve) -> str:
    """The same without the joint and the numbers of the range, for a card."""
    share = f"{what.share:.0%} of its squared error".replace("%", " %")
    if isinstance(what, Region):
        return f"{share} in a range of {_words(joint, what.quantity)}"
    if what.quantity is None:
        return f"a constant offset is {share}"
    return f"{_words(joint, what.quantity)} explains {share}"


def _range(joint: int, region: Region) -> str:
    quantity = region.quantity
    span = _span(region)
    if quantity.kind == "|dq|" and quantity.own:
        return span
    if quantity.kind == "time":
        return f"{span} into a run"
    if quantity.kind == "reversal_time":
        return f"{span} after a reversal"
    if quantity.kind == "reversal_travel":
        return f"{span} past a reversal"
    if quantity.kind == "moving":
        return f"{span} after a rest"
    return f"while {_words(joint, quantity)} is {span}"


def _span(region: Region) -> str:
    unit = region.quantity.unit
    far = NEGLIGIBLE * max(abs(region.low), abs(region.high))
    region = replace(
        region,
        low=0.0 if abs(region.low) < far else region.low,
        high=0.0 if abs(region.high) < far else region.high,
    )
    if region.open_low:
        return f"below {_number(region.high)} {unit}"
    if region.open_high:
        return f"above {_number(region.low)} {unit}"
    digits = 2
    while (low := _number(region.low, digits)) == (high := _number(region.high, digits)):
        if digits == MOST_DIGITS:
            return f"at {low} {unit}"
        digits += 1
    return f"between {low} and {high} {unit}"


def _words(joint: int, quantity: Quantity) -> str:
    whose = "its" if quantity.joint == joint else f"joint {quantity.joint + 1}'s"
    return {
        "q": f"{whose} position",
        "dq": f"{whose} velocity",
        "|dq|": f"{whose} speed",
        "ddq": f"{whose} acceleration",
        "load": f"{whose} load",
        "temperature": f"{whose} temperature",
        "time": "the time in the run",
        "reversal_time": "the time since its last reversal",
        "reversal_travel": f"{whose} travel since its last reversal",
        "moving": "the time since its last rest",
    }[quantity.kind]


def _number(value: float, digits: int = 2) -> str:
    """So many digits, without the exponent that nobody reads: 0.034, 1.2, 120."""
    if value == 0:
        return "0"
    places = max(0, digits - 1 - int(np.floor(np.log10(abs(value)))))
    return f"{value:.{places}f}"
