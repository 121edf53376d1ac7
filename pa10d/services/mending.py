"""What the checks advise, in the words of the file that was read: its columns, their units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from pa10d.checks import CheckFinding, Mend
from pa10d.store.column_choices import Choice, composed, rules_of

Names = Mapping[str, str]


def in_words_of(finding: CheckFinding, called: Names, said: Names, n: int) -> CheckFinding:
    """Its ``--map`` options with the file's own columns. called: field -> column; said: column ->
    the unit that it is read in so far."""
    advice = finding.advice
    for mend in finding.mends:
        own = rules_of(_choices(mend, called, said, n), n)
        advice = advice.replace(f" {mend.option}", "".join(f" '{rule}'" for rule in own))
    return replace(finding, advice=advice)


def mends(finding: CheckFinding, called: Names, said: Names, n: int) -> list[Choice]:
    """What would mend it, as far as nothing is left to be filled in."""
    whole = (mend for mend in finding.mends if mend.complete)
    return [choice for mend in whole for choice in _choices(mend, called, said, n)]


def _choices(mend: Mend, called: Names, said: Names, n: int) -> list[Choice]:
    if mend.source:
        column = called.get(mend.source, mend.source)
        return [Choice(column, mend.field, said.get(column, ""))]
    prefix, template, _ = mend.field.partition("{n}")
    fields = [f"{prefix}{j}" for j in range(1, n + 1)] if template else [mend.field]
    columns = [called.get(one, one) for one in fields]
    return [
        Choice(column, one, composed(said.get(column, ""), mend.unit))
        for column, one in zip(columns, fields, strict=True)
    ]
