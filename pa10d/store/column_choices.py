"""What a person, or a guess, takes each column of a file for; as rules of a mapping, and back."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pa10d.store.column_mapping import FIELD, PER_JOINT, UNITS, own_unit

_NUMBER = re.compile(r"\d+")
_OPERATORS = re.compile(r"[*/-]")
MARKS = (("{n}", 0), ("{n-1}", 1))
NOTHING = ("", "1", "1.0")  # a unit that says no more than SI


@dataclass(frozen=True)
class Choice:
    """A column, the field that it is read as, and what its numbers are in ('': SI, or what stands
    behind its name)."""

    column: str
    field: str
    unit: str = ""


def rules_of(choices: Sequence[Choice], n: int) -> list[str]:
    """``COLUMN=FIELD`` options, one for all joints where their columns are called alike; none for
    what a column's own name says already. A field that is chosen twice is named twice, and refused
    by who reads the rules."""
    by_field: dict[str, Choice] = {}
    rules = []
    for choice in choices:
        if by_field.setdefault(choice.field, choice) is not choice:
            rules.append(f"{_written(choice)}={choice.field}")
    if (time := by_field.get("time")) and _written(time) != "time":
        rules.append(f"{_written(time)}=time")
    for prefix in PER_JOINT:
        found = [by_field.get(f"{prefix}{j}") for j in range(1, n + 1)]
        there = [choice for choice in found if choice is not None]
        template = _template(there) if len(there) == n else None
        if template is not None:
            rules += [] if template == f"{prefix}{{n}}" else [f"{template}={prefix}"]
        else:
            rules += [f"{_written(c)}={c.field}" for c in there if _written(c) != c.field]
    return rules


def composed(old: str, new: str) -> str:
    """The unit of numbers in ``old`` whose values are ``new`` of what they were taken for."""
    if old in NOTHING or UNITS.get(old) == 1.0:
        return new
    if new in UNITS and new in _OPERATORS.split(old):
        return old  # said already, of this column
    if not new.startswith("-"):
        return f"{old}*{new}"
    turned = old[1:] if old.startswith("-") else f"-{old}"
    rest = new[1:]
    turned = "" if turned in NOTHING else turned
    return turned if rest == "1" else f"{turned}*{rest}" if turned else rest


def field_of(column: str, fields: Mapping[str, str], n: int) -> str | None:
    """What a column is read as, by a mapping or by its own name; None: a further channel."""
    if column in fields:
        return fields[column]
    match = FIELD.fullmatch(column)
    taken = column in fields.values()
    if match is None or taken or (match[3] and int(match[3]) > n):
        return None
    return column


def _written(choice: Choice) -> str:
    """The column and its unit, as a rule names them."""
    own = own_unit(choice.column)
    if own and not choice.unit:
        return f"{choice.column}[1]" if UNITS[own] != 1.0 else choice.column
    if not choice.unit or choice.unit == own:
        return choice.column
    return f"{choice.column}[{choice.unit}]"


def _template(choices: Sequence[Choice]) -> str | None:
    """What the columns of joint 1 … n have in common, the joint's number as ``{n}``."""
    first, units = choices[0], {choice.unit for choice in choices}
    if len(units) > 1:
        return None
    suffix = _written(first).removeprefix(first.column)
    for number in _NUMBER.finditer(first.column):
        for mark, less in MARKS:
            begin, end = first.column[: number.start()], first.column[number.end() :]
            if all(c.column == f"{begin}{j - less}{end}" for j, c in enumerate(choices, 1)):
                return f"{begin}{mark}{end}{suffix}"
    return None
