"""What the checks advise, in the words of the file that was read: its columns, their units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from pa10d.checks import Finding
from pa10d.store.column_choices import Choice, composed, rules_of
from pa10d.store.column_mapping import read_unit

_OPTION = re.compile(r"'(time|(?:q|dq|tau)(?:\d+|\{n\}))\[([^\]]+)\]=(?:time|(?:q|dq|tau)\d*)'")
Names = Mapping[str, str]


def in_words_of(finding: Finding, called: Names, said: Names, n: int) -> Finding:
    """Its ``--map`` options with the file's own columns. called: field -> column; said: column ->
    the unit that it is read in so far."""

    def own(match: re.Match[str]) -> str:
        rules = rules_of(_choices(match[1], match[2], called, said, n), n)
        return " ".join(f"'{rule}'" for rule in rules)

    return replace(finding, advice=_OPTION.sub(own, finding.advice))


def mends(finding: Finding, called: Names, said: Names, n: int) -> list[Choice]:
    """What would mend it, as far as its advice leaves nothing to be filled in. finding: as the
    checks made it."""
    out = []
    for field, unit in _OPTION.findall(finding.advice):
        try:
            read_unit(unit)
        except (ValueError, ZeroDivisionError):
            continue  # RATIO, COUNTS: only the owner knows
        out += _choices(field, unit, called, said, n)
    return out


def _choices(field: str, unit: str, called: Names, said: Names, n: int) -> list[Choice]:
    prefix, template, _ = field.partition("{n}")
    fields = [f"{prefix}{j}" for j in range(1, n + 1)] if template else [field]
    columns = [called.get(one, one) for one in fields]
    return [
        Choice(column, one, composed(said.get(column, ""), unit))
        for column, one in zip(columns, fields, strict=True)
    ]
