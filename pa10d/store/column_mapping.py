"""What a file calls its columns, and in which units: ``--map 'joint_{n}_position[deg]=q'``."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from pa10d.common.errors import UserError

FIELD = re.compile(r"(time)|(q|dq|tau|i|temp)([1-9]\d*)")
PER_JOINT = ("q", "dq", "tau", "i", "temp")
UNITS = {
    "s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0,
    "rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "°": math.pi / 180, "rev": 2 * math.pi,
    "m": 1.0, "mm": 1e-3,
    "rad/s": 1.0, "deg/s": math.pi / 180, "°/s": math.pi / 180, "rpm": math.pi / 30,
    "rev/s": 2 * math.pi, "m/s": 1.0, "mm/s": 1e-3,
    "Nm": 1.0, "N·m": 1.0, "N.m": 1.0, "N*m": 1.0, "mNm": 1e-3, "Nmm": 1e-3, "kNm": 1e3, "N": 1.0,
    "A": 1.0, "mA": 1e-3, "°C": 1.0, "degC": 1.0, "C": 1.0,
}  # fmt: skip
"""Unit -> what one of it is in SI."""
_WITH_UNIT = re.compile(r"(.+?)\s*[\[(]([^\[\]()]+)[\])]")
_NUMBER = "{n}"
_FROM_ZERO = "{n-1}"


@dataclass(frozen=True)
class Rule:
    """column may hold ``{n}``, the joint's number from 1, or ``{n-1}``; field likewise."""

    text: str
    column: str
    field: str

    @property
    def of_every_joint(self) -> bool:
        return _NUMBER in self.column or _FROM_ZERO in self.column

    def named(self, joint: int) -> tuple[str, str]:
        """Column and field of a joint, numbered from 1."""
        column = self.column.replace(_NUMBER, str(joint)).replace(_FROM_ZERO, str(joint - 1))
        return column, f"{self.field}{joint}" if self.of_every_joint else self.field


@dataclass(frozen=True)
class Resolved:
    """fields: column -> field; factors: column -> SI units per unit."""

    fields: dict[str, str]
    factors: dict[str, float]


def read_mapping(pairs: Sequence[str]) -> list[Rule]:
    """``COLUMN=FIELD`` options."""
    rules: list[Rule] = []
    for pair in pairs:
        column, sign, name = pair.rpartition("=")
        rule = Rule(pair, column.strip(), name.strip().replace(_NUMBER, ""))
        good = rule.field in PER_JOINT if rule.of_every_joint else FIELD.fullmatch(rule.field)
        if not sign or not rule.column or not good:
            raise UserError(
                f"--map {pair}: expected COLUMN=FIELD, FIELD being time, q1, tau1, dq1, i1, temp1 …"
                ", or COLUMN with {n} for every joint and FIELD q, tau, dq, i or temp; "
                "[unit] behind COLUMN where it is not SI"
            )
        if any(rule.column == other.column or rule.field == other.field for other in rules):
            raise UserError(
                f"--map {pair}: found a second time, expected each column and field once"
            )
        rules.append(rule)
    return rules


def resolve(rules: Sequence[Rule], names: Sequence[str], n: int, where: str) -> Resolved:
    """The rules for a file with these columns and a robot of n joints."""
    out, found = Resolved({}, {}), ", ".join(names)
    found = found if len(found) <= 120 else f"{found[:117]}..."
    for rule in rules:
        for joint in range(1, n + 1) if rule.of_every_joint else (0,):
            written, field = rule.named(joint)
            column, factor = _column(written, names, rule.text)
            if column is None:
                raise UserError(f"{where}: no column {written!r}, expected by --map; found {found}")
            out.fields[column] = field
            if factor != 1.0:
                out.factors[column] = factor
    return out


def _column(written: str, names: Sequence[str], text: str) -> tuple[str | None, float]:
    """The column that is meant, and the factor of the unit behind its name."""
    match = _WITH_UNIT.fullmatch(written)
    if written in names:
        return written, UNITS.get(match[2].strip(), 1.0) if match else 1.0
    if match is None or match[1] not in names:
        return None, 1.0
    unit = match[2].strip()
    if unit not in UNITS:
        raise UserError(f"--map {text}: unit {unit!r}, expected one of {', '.join(UNITS)}")
    return match[1], UNITS[unit]
