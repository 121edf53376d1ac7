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
NAMES = ("frame_id", "name.")  # columns of words that rows of ROS messages have
NANOSECONDS = ("nanosec", "nsec", "nsecs", "nanosecs")
LOOK = 1 << 16  # bytes that are looked at to tell the dialect
ABOVE = 60  # lines within which the first row of numbers is looked for
FEWEST = 3  # columns of a recording: a stamp, a position, a torque
SPELT = {
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us",
    "nsec": "ns", "degree": "deg", "degrees": "deg", "degs": "deg", "radian": "rad",
    "radians": "rad", "degree/s": "deg/s", "degrees/s": "deg/s", "radian/s": "rad/s",
    "radians/s": "rad/s", "rad/sec": "rad/s", "deg/sec": "deg/s", "N m": "Nm", "newton meter": "Nm",
    "nm": "Nm", "NM": "Nm", "amp": "A", "amps": "A", "ampere": "A",
}  # fmt: skip
"""How a row of units may write what a mapping knows by another word."""
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
    _refuse_json(path, body[0])
    named_by_excel = _EXCEL.fullmatch(body[0].strip())
    body = body[1:] if named_by_excel and len(body) > 1 else body
    above = 0 if named_by_excel else _lines_above(body)
    body = body[above:]
    delimiter = named_by_excel[1] if named_by_excel else _delimiter(body[0])
    comma = delimiter != "," and bool(_DECIMAL_COMMA.search(" ".join(body[:20])))
    first = _cells(body[0], delimiter)
    echoed = _echoed(body, delimiter)
    bare = bool(echoed) or all(_number(cell, comma) is not None for cell in first)
    units: list[str] = []
    if echoed:
        names = echoed
    elif bare:
        names = _names_above(lines[:comments], delimiter, len(first))
    else:
        names, body = first, body[1:]
        units = _units(body[0], delimiter, len(names), comma) if body else []
        body = body[1:] if units else body
    named = [f"{name}[{unit}]" if unit else name for name, unit in _paired(names, units)]
    _refuse_twice(path, named, len(lines) - len(body))
    below = len(lines) - len(body) + 1
    remarks = [f"no header: columns are called {names[0]} … {names[-1]}"] if bare else []
    if echoed:
        remarks = ["rows of ros2 topic echo --csv, of sensor_msgs/JointState by their shape"]
    if above:
        remarks.append(f"{above} {'line' if above == 1 else 'lines'} above the header left out")
    found = _numbers(path, body, named, delimiter, comma, below)
    left = [name for name in named if name not in found and not (echoed and name.startswith(NAMES))]
    if left:
        remarks.append(f"no numbers in {', '.join(left)}: left out")
    return ForeignTable(found, remarks)


def _refuse_json(path: Path, line: str) -> None:
    if line.lstrip()[:1] in ("{", "[") and line.count('"') > 1:
        raise UserError(f"{path}: JSON; expected a table, such as pandas' read_json(…).to_csv(…)")


def _refuse_twice(path: Path, names: list[str], line: int) -> None:
    """Columns of one name: which of them is meant nobody knows."""
    seen: dict[str, int] = {}
    for k, name in enumerate(names, 1):
        if name and name in seen:
            where = f"{path}:{max(line, 1)}"
            raise UserError(
                f"{where}: columns {seen[name]} and {k} are both {name!r}; expected one"
            )
        seen[name] = k


def _lines_above(body: list[str]) -> int:
    """How many lines of a report stand above the names: the first row of numbers tells how wide
    the table is, and the names are the first line above it that is as wide."""
    for k, line in enumerate(body[:ABOVE]):
        sign = _delimiter(line)
        width = len(_cells(line, sign))
        if width < FEWEST or not _mostly_numbers(_cells(line, sign)):
            continue
        alike = [i for i in range(k) if len(_cells(body[i], sign)) == width]
        return alike[0] if alike else 0
    return 0


def _mostly_numbers(cells: list[str]) -> bool:
    found = [_number(cell, comma=True) is not None for cell in cells if cell]
    return 2 * sum(found) > len(found)


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
    cells = [cell if cell in UNITS else SPELT.get(cell, SPELT.get(cell.lower(), cell))
             for cell in cells]  # fmt: skip
    known = [cell in UNITS or not cell or cell == "-" for cell in cells]
    numbers = any(_number(cell, comma) is not None for cell in cells)
    return cells if len(cells) == count and all(known) and not numbers else []


def _echoed(body: list[str], delimiter: str) -> list[str]:
    """Names for the rows of ``ros2 topic echo --csv`` of joint states: seconds, nanoseconds, a
    frame, the joints' names, their positions, speeds and efforts."""
    rows = [_cells(line, delimiter) for line in body[:2]]
    if len(rows) < 2 or len(rows[0]) < 6 or not all(row[0].isdigit() for row in rows):
        return []
    words = [k for k, cell in enumerate(rows[0]) if _number(cell, comma=False) is None]
    joints = [rows[0][k] for k in words if k > 2]
    numbers = len(rows[0]) - 3 - len(joints)
    kinds = ("position", "velocity", "effort")
    told = (
        joints
        and words[-len(joints) :] == list(range(3, 3 + len(joints)))
        and rows[0][1].isdigit()
        and numbers == len(kinds) * len(joints)  # of two it is not said which two
        and rows[0][2 : 3 + len(joints)] == rows[1][2 : 3 + len(joints)]
    )
    if not told:
        return []
    blocks = [f"{joint}.{kind}" for kind in kinds for joint in joints]
    return ["sec", "nanosec", "frame_id", *(f"name.{joint}" for joint in joints), *blocks]


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
