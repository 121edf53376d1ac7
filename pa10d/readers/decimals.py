"""How a text file writes its numbers: decimal commas, thousands in groups, FORTRAN's exponents.

``1,234`` is one and a bit, or more than a thousand: told by what else stands in its column, and by
the other columns of the file. Where nothing tells, nothing is assumed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

SIGNS = (".", ",")
_SPACES = "[ \u00a0\u2009\u202f'\u2019]"
_SPACED = re.compile(rf"(?<=\d){_SPACES}(?=\d{{3}}(?!\d))")
_MINUS = str.maketrans({"\u2212": "-", "\u2013": "-"})
_FORTRAN = re.compile(r"(\d\.\d*|\.\d+)[dD](?=[-+]?\d)")
_GROUPS = {s: re.compile(rf"[-+]?[1-9]\d{{0,2}}(?:{re.escape(s)}\d{{3}})+") for s in SIGNS}
_WHOLE = {
    s: re.compile(rf"[-+]?[1-9]\d{{0,2}}(?:{re.escape(s)}\d{{3}})+(?:{re.escape(d)}\d*)?")
    for s, d in (SIGNS, SIGNS[::-1])
}
"""Groups of three digits, then perhaps the other sign and decimals."""


class Ambiguous(ValueError):
    """A cell that may be a number of thousands or one with decimals."""

    def __init__(self, column: int, cell: str) -> None:
        super().__init__(cell)
        self.column, self.cell = column, cell


@dataclass(frozen=True)
class Style:
    """decimal: the sign before decimals; group: that between thousands, where there is one."""

    decimal: str = "."
    group: str = ""

    def number(self, cell: str) -> float | None:
        """None for what is no number in this style."""
        if self.group and self.group in cell:
            if not _WHOLE[self.group].fullmatch(cell):
                return None
            cell = cell.replace(self.group, "")
        if self.decimal != ".":
            if "." in cell:
                return None
            cell = cell.replace(self.decimal, ".")
        try:
            return float(cell)
        except ValueError:
            return None


def tidy(column: Sequence[str]) -> list[str]:
    """Cells with a plain minus, without spaces or apostrophes between thousands, with E for D."""
    text = "\n".join(column).translate(_MINUS)
    if re.search(_SPACES, text):
        text = _SPACED.sub("", text)
    if "d" in text or "D" in text:
        text = _FORTRAN.sub(r"\1e", text)
    return text.split("\n") if column else []


def is_number(cell: str) -> bool:
    """In whatever style."""
    (cell,) = tidy([cell])
    return any(style.number(cell) is not None for style in _STYLES)


def styles_of(columns: Sequence[Sequence[str]]) -> list[Style]:
    """One a column, of cells that are tidy; Ambiguous where two readings are left."""
    told = [_decimal_of(column) for column in columns]
    there = {sign for sign in told if sign in SIGNS}
    out = []
    for k, (sign, column) in enumerate(zip(told, columns, strict=True)):
        if sign is not None and sign not in SIGNS:  # groups of three throughout
            s, other = sign[0], SIGNS[1 - SIGNS.index(sign[0])]
            if there == {other}:
                sign = other
            elif there == {s} or (s == "." and not there):
                sign = s
            else:
                raise Ambiguous(k, next(cell for cell in column if s in cell))
        decimal = sign or "."
        group = SIGNS[1 - SIGNS.index(decimal)]
        out.append(Style(decimal, group if any(group in cell for cell in column) else ""))
    return out


def values_of(column: Sequence[str], style: Style) -> list[float | None]:
    """Empty cells are nan."""
    if style == Style():
        return [_plain(cell) if cell else math.nan for cell in column]
    return [style.number(cell) if cell else math.nan for cell in column]


def _plain(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _decimal_of(column: Sequence[str]) -> str | None:
    """The sign before decimals as the column alone tells it, None where it has none of them, and
    the sign followed by a question mark where each cell that has it could be thousands."""
    open_: str | None = None
    for cell in column:
        places = [cell.rfind(sign) for sign in SIGNS]
        if places == [-1, -1]:
            continue
        if min(places) >= 0:
            last = SIGNS[places[1] > places[0]]
            if _WHOLE[SIGNS[1 - SIGNS.index(last)]].fullmatch(cell):
                return last
            continue  # no number: said by who reads it
        sign = SIGNS[places[1] >= 0]
        if not _GROUPS[sign].fullmatch(cell):
            if Style(sign).number(cell) is not None:
                return sign
        elif cell.count(sign) > 1:
            return SIGNS[1 - SIGNS.index(sign)]
        else:
            open_ = f"{sign}?"
    return open_


_STYLES = (Style(), Style(","), Style(".", ","), Style(",", "."))
