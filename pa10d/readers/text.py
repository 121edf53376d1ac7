"""Delimited text of any dialect: other delimiters, decimal commas, comments, units below the names,
other encodings. Plain CSV has a reader of its own, which names the cell that is wrong."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import numpy as np

from pa10d.common.errors import UserError
from pa10d.readers.moments import seconds_since_first
from pa10d.readers.packed import DAMAGED, unpacked
from pa10d.readers.table import ForeignTable
from pa10d.store.channels import Array
from pa10d.store.column_mapping import UNITS
from pa10d.store.csv_locate import most_unpacked

DELIMITERS = (";", "\t", "|", ",")
COMMENT = ("#", "%", "//")
NANOSECONDS = ("nanosec", "nsec", "nsecs", "nanosecs")
LOOK = 1 << 16  # bytes that are looked at to tell the dialect
_EXCEL = re.compile(r"sep=(.)", re.I)
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?")


def read_text(path: Path) -> ForeignTable:
    """Every column that holds numbers, and what stands for them."""
    text = _decoded(path)
    lines = text.splitlines()
    comments = 0
    while comments < len(lines) and _is_comment(lines[comments]):
        comments += 1
    body = lines[comments:]
    while body and not body[0].strip():
        body = body[1:]
    if not body:
        raise UserError(f"{path}: an empty file; expected a header and rows of numbers")
    named_by_excel = _EXCEL.fullmatch(body[0].strip())
    body = body[1:] if named_by_excel and len(body) > 1 else body
    delimiter = named_by_excel[1] if named_by_excel else _delimiter(body[0])
    comma = delimiter != "," and bool(_DECIMAL_COMMA.search(" ".join(body[:20])))
    first = _cells(body[0], delimiter)
    bare = all(_number(cell, comma) is not None for cell in first)
    if bare:
        names, units = _names_above(lines[:comments], delimiter, len(first)), []
    else:
        names, body = first, body[1:]
        units = _units(body[0], delimiter, len(names), comma) if body else []
        body = body[1:] if units else body
    named = [f"{name}[{unit}]" if unit else name for name, unit in _paired(names, units)]
    below = len(lines) - len(body) + 1
    remarks = [f"no header: columns are called {names[0]} … {names[-1]}"] if bare else []
    found = _numbers(path, body, named, delimiter, comma, below)
    left = [name for name in named if name not in found]
    if left:
        remarks.append(f"no numbers in {', '.join(left)}: left out")
    return ForeignTable(found, remarks)


def numbers(cells: list[str]) -> bool:
    """Whether this is a row of samples, not of names."""
    return all(_number(cell, comma=False) is not None for cell in cells)


def stamps_in_two(names: list[str]) -> list[tuple[str, str]]:
    """Columns of seconds, each with the one that has its nanoseconds."""
    out = []
    for sec in names:
        end = sec.rpartition(".")[2]
        if end.lower() in ("sec", "secs"):
            fine = (sec[: len(sec) - len(end)] + word for word in NANOSECONDS)
            out += [(sec, name) for name in fine if name in names][:1]
    return out


def units_or_moments(line: str) -> bool:
    """Whether the row below the names holds their units, or stamps that are no numbers."""
    cells = _cells(line, ",")
    moments = any(":" in cell and seconds_since_first([cell]) is not None for cell in cells)
    return moments or bool(_units(line, ",", len(cells), comma=False))


def _decoded(path: Path) -> str:
    most = most_unpacked(path)
    try:
        with unpacked(path) as file:
            raw = file.read(most + 1)
    except DAMAGED as error:
        raise UserError(f"{path}: the packed data are damaged; expected a whole file") from error
    if len(raw) > most:
        raise UserError(f"{path}: becomes more than {most} bytes of text; expected a recording")
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return raw.decode("utf-16", "replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in raw[:LOOK]:
            raise UserError(
                f"{path}: neither text nor a format that is known; expected CSV, a ROS 2 bag "
                "(.db3, .mcap), Parquet, MAT, .npz or a CAN log"
            ) from None
        return raw.decode("latin-1")


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(COMMENT)


def _delimiter(line: str) -> str:
    counts = {sign: line.count(sign) for sign in DELIMITERS}
    best = max(DELIMITERS, key=lambda sign: counts[sign])
    if counts[";"]:
        return ";"
    return best if counts[best] else " "


def _cells(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return line.split()
    try:
        found = next(csv.reader(io.StringIO(line), delimiter=delimiter), [])
    except csv.Error:  # an open quote with more behind it than any cell has
        found = line.split(delimiter)
    return [cell.strip() for cell in found]


def _number(cell: str, comma: bool) -> float | None:
    try:
        return float(cell.replace(",", ".") if comma else cell)
    except ValueError:
        return None


def _names_above(comments: list[str], delimiter: str, count: int) -> list[str]:
    """The last comment that names as many columns; else c1 … for ``--map``."""
    for line in reversed(comments):
        bare = line.lstrip().lstrip("#%/").strip()
        for sign in (delimiter, ",", " "):
            cells = [c for c in _cells(bare, sign) if c] if bare else []
            if len(cells) == count:
                return cells
    return [f"c{k + 1}" for k in range(count)]


def _units(line: str, delimiter: str, count: int, comma: bool) -> list[str]:
    cells = [cell.strip("[]() ") for cell in _cells(line, delimiter)]
    known = [cell in UNITS or not cell or cell == "-" for cell in cells]
    numbers = any(_number(cell, comma) is not None for cell in cells)
    return cells if len(cells) == count and all(known) and not numbers else []


def _paired(names: list[str], units: list[str]) -> list[tuple[str, str]]:
    units = units or [""] * len(names)
    return [
        (name, unit if UNITS.get(unit, 1.0) != 1.0 and "[" not in name else "")
        for name, unit in zip(names, units, strict=True)
    ]


def _numbers(
    path: Path, body: list[str], names: list[str], delimiter: str, comma: bool, below: int
) -> dict[str, Array]:
    rows = [
        (below + k, _cells(line, delimiter))
        for k, line in enumerate(body)
        if line.strip() and not _is_comment(line)
    ]
    for line, cells in rows:
        if len(cells) != len(names):
            last = "; was the file cut off?" if line == rows[-1][0] else ""
            found = f"{path}:{line}: found {len(cells)} columns, expected {len(names)}{last}"
            raise UserError(found)
    out: dict[str, Array] = {}
    for k, name in enumerate(names):
        column = [cells[k] for _, cells in rows]
        values = [_number(cell, comma) if cell else np.nan for cell in column]
        if all(value is not None for value in values):
            out[name] = np.array(values, dtype=np.float64)
        elif (stamps := seconds_since_first(column)) is not None:
            out[name] = stamps
        elif sum(value is not None for value in values) > len(values) / 2:
            row = next(i for i, value in enumerate(values) if value is None)
            raise UserError(
                f"{path}:{rows[row][0]}: column {k + 1} ({name}): found {column[row]!r}, "
                "expected a finite number"
            )
    return out
