"""What a file calls its columns, and in which units: ``--map 'joint_{n}_position[deg]=q'``."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.measurement.counters import centred, unwrapped

Array = NDArray[np.float64]

FIELD = re.compile(r"(time)|(q|dq|tau|i|temp)([1-9]\d*)")
PER_JOINT = ("q", "dq", "tau", "i", "temp")
UNITS = {
    "s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0, "day": 86_400.0,
    "rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "°": math.pi / 180, "rev": 2 * math.pi,
    "m": 1.0, "mm": 1e-3,
    "rad/s": 1.0, "deg/s": math.pi / 180, "°/s": math.pi / 180, "rpm": math.pi / 30,
    "rev/s": 2 * math.pi, "m/s": 1.0, "mm/s": 1e-3,
    "Nm": 1.0, "N·m": 1.0, "N.m": 1.0, "N*m": 1.0, "mNm": 1e-3, "Nmm": 1e-3, "kNm": 1e3,
    "cNm": 1e-2, "Ncm": 1e-2, "N": 1.0,
    "A": 1.0, "mA": 1e-3, "°C": 1.0, "degC": 1.0, "C": 1.0,
}  # fmt: skip
"""Unit -> what one of it is in SI."""
SPELT = {"temperature": "temp", "current": "i", "t": "time"}
"""What arrays are called in files -> what their columns are called here."""
ANGLES = ("rad", "mrad", "deg", "°", "rev")
PERIOD = re.compile(r"wrap(2pi|\d+(?:\.\d+)?(?:e\d+)?)")
"""Numbers that begin anew after so many: angles after a turn, counters after a word."""
WORDS = {"i8": 2.0**8, "i16": 2.0**16, "i32": 2.0**32}
"""Numbers with a sign that were read without it: 65535 for -1."""
_WITH_UNIT = re.compile(r"(.+?)\s*[\[(]([^\[\]()]+)[\])]")
_STRANGE = re.compile(
    r"%|‰|per ?(cent|mil+e?)|.*%|counts?|cts?|inc(rements?)?|ticks?|pulses?|lsb|raw|m?V|volts?|W|"
    r"(ft|in|lbf?|oz(f)?|kgf?|kp|gf?)[\W_]*(ft|in|lbf?|ozf?|c?m)?",
    re.I,
)
"""Shares of a rated torque, numbers of a converter, units of other systems."""
_BLOCK = re.compile(rf"^({'|'.join(SPELT)})(?=\d*\s*(?:[\[(]|$))")
_OPERATOR = re.compile(r"[*/]")
_NUMBER = "{n}"
_FROM_ZERO = "{n-1}"


@dataclass(frozen=True)
class Rule:
    """column may hold ``{n}``, the joint's number from 1, or ``{n-1}``; field likewise.

    optional: for files that have the column, and no other for the same field."""

    text: str
    column: str
    field: str
    optional: bool = False

    @property
    def of_every_joint(self) -> bool:
        return _NUMBER in self.column or _FROM_ZERO in self.column

    def named(self, joint: int) -> tuple[str, str]:
        """Column and field of a joint, numbered from 1."""
        column = self.column.replace(_NUMBER, str(joint)).replace(_FROM_ZERO, str(joint - 1))
        return column, f"{self.field}{joint}" if self.of_every_joint else self.field


@dataclass(frozen=True)
class Unit:
    """factor: SI units per unit; word: how many values a counter has whose sign was lost; period:
    after how many the numbers begin anew."""

    factor: float = 1.0
    word: float | None = None
    period: float | None = None

    def __call__(self, values: Array) -> Array:
        """(N,) in SI units."""
        if self.word is not None:
            values = np.mod(values + 0.5 * self.word, self.word) - 0.5 * self.word
        if self.period is not None:
            values = centred(unwrapped(values, self.period), self.period)
        return values if self.factor == 1.0 else values * self.factor


def stamps_of(values: Array, unit: Unit) -> Array:
    """(N,) s, rising or not, of a column that was read in ``unit`` already: days are counted from
    the year 0, and begin at the first sample's day."""
    day = UNITS["day"]
    return values - values[0] // day * day if unit.factor == day and len(values) else values


@dataclass(frozen=True)
class Resolved:
    """fields: column -> field; units: column -> what its numbers are in, where that is not SI;
    said: the same in the words of the rule."""

    fields: dict[str, str]
    units: dict[str, Unit]
    said: dict[str, str] = field(default_factory=dict)


def own_unit(name: str) -> str:
    """What stands in brackets behind a column's name; '' where that is no unit."""
    match = _WITH_UNIT.fullmatch(name)
    return match[2].strip() if match and match[2].strip() in UNITS else ""


def of_strange_units(given: Resolved, where: str) -> list[str]:
    """Sentences on columns that are taken as they are, and say themselves that they are in a unit
    that is not known."""
    said = []
    for name, meant in given.fields.items():
        match = _WITH_UNIT.fullmatch(name)
        unit = match[2].strip() if match else ""
        if name not in given.units and unit not in UNITS and _STRANGE.fullmatch(unit):
            said.append(
                f"{where}: {name} is taken as it is, though {unit} is no unit that is known: "
                f"--map '{name}[FACTOR]={meant}' with what one of it is in SI"
            )
    return said


def names_an_angle(unit: str) -> bool:
    """Whether a unit says what a position is in, not only a factor of it."""
    return any(part in ANGLES for part in re.split(r"[*/-]", unit))


def read_unit(text: str) -> Unit:
    """``deg``, ``-1``, ``1/100``, ``-deg``, ``i16*0.001``, ``wrap360*deg``; ValueError for others.
    A period is in what stands before it: ``deg*wrap2pi`` is the same."""
    sign, bare = (-1.0, text[1:].strip()) if text.startswith("-") else (1.0, text)
    if bare in UNITS:
        return Unit(sign * UNITS[bare])
    factor, word, period = sign, None, None
    operators = ["*", *_OPERATOR.findall(bare)]
    for operator, part in zip(operators, _OPERATOR.split(bare), strict=True):
        name = part.strip()
        if name in WORDS and operator == "*" and word is None:
            word = WORDS[name]
            continue
        if (match := PERIOD.fullmatch(name)) and operator == "*" and period is None:
            once = 2 * math.pi if match[1] == "2pi" else float(match[1])
            period = once / abs(factor)
            continue
        value = UNITS.get(name) or float(name)
        factor = factor * value if operator == "*" else factor / value
    if not math.isfinite(factor) or factor == 0 or period == 0:
        raise ValueError(text)
    return Unit(factor, word, period)


def read_mapping(pairs: Sequence[str], kept: Sequence[str] = ()) -> list[Rule]:
    """``COLUMN=FIELD`` options, and those that a profile has kept."""
    rules: list[Rule] = []
    for pair in pairs:
        rule = read_rule(pair)
        if any(rule.column == other.column or rule.field == other.field for other in rules):
            raise UserError(
                f"--map {pair}: found a second time, expected each column and field once"
            )
        rules.append(rule)
    return [*rules, *(replace(read_rule(pair), optional=True) for pair in kept)]


def read_rule(pair: str) -> Rule:
    """One of them."""
    column, sign, name = pair.rpartition("=")
    rule = Rule(pair, column.strip(), name.strip().replace(_NUMBER, ""))
    good = rule.field in PER_JOINT if rule.of_every_joint else FIELD.fullmatch(rule.field)
    if not sign or not rule.column or not good:
        raise UserError(
            f"--map {pair}: expected COLUMN=FIELD, FIELD being time, q1, tau1, dq1, i1, temp1 …"
            ", or COLUMN with {n} for every joint and FIELD q, tau, dq, i or temp; "
            "[unit] behind COLUMN where it is not SI"
        )
    return rule


def resolve(rules: Sequence[Rule], names: Sequence[str], n: int, where: str) -> Resolved:
    """The rules for a file with these columns and a robot of n joints."""
    out, found = Resolved({}, {}), ", ".join(filter(None, names)) or "no names in its header"
    found = found if len(found) <= 120 else f"{found[:117]}..."
    for rule in rules:
        if rule.optional and not _applies(rule, names, n, out):
            continue
        for joint in range(1, n + 1) if rule.of_every_joint else (0,):
            written, meant = rule.named(joint)
            column, unit = _column(written, names, rule.text)
            if column is None:
                raise UserError(f"{where}: no column {written!r}, expected by --map; found {found}")
            out.fields[column] = meant
            if unit != Unit():
                out.units[column] = unit
            said = written[len(column) :].strip(" [()]") or own_unit(column)
            if said:  # rad, too: somebody answers for it
                out.said[column] = said
    return out


def _applies(rule: Rule, names: Sequence[str], n: int, taken: Resolved) -> bool:
    """Whether every column of the rule is there, and neither it nor its field is spoken for."""
    for joint in range(1, n + 1) if rule.of_every_joint else (0,):
        written, meant = rule.named(joint)
        column, _ = _column(written, names, rule.text)
        if column is None or column in taken.fields or meant in taken.fields.values():
            return False
    return True


def _column(written: str, names: Sequence[str], text: str) -> tuple[str | None, Unit]:
    """The column that is meant, by its file's name or by ours, and the unit behind its name."""
    match = _WITH_UNIT.fullmatch(written)
    if written not in names and (match is None or match[1] not in names):
        written = _BLOCK.sub(lambda block: SPELT[block[0]], written)
        match = _WITH_UNIT.fullmatch(written)
    if written in names:
        return written, Unit(UNITS.get(match[2].strip(), 1.0)) if match else Unit()
    if match is None or match[1] not in names:
        return None, Unit()
    unit = match[2].strip()
    try:
        return match[1], read_unit(unit)
    except (ValueError, ZeroDivisionError):
        raise UserError(
            f"--map {text}: unit {unit!r}, expected a factor such as -1, 0.01 or 1/100, "
            "i16 for numbers that lost their sign, wrap360 for those that begin anew, "
            f"or one of {', '.join(UNITS)}"
        ) from None
