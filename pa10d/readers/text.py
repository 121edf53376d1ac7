"""Delimited text of any dialect: other delimiters, decimal commas, comments, units below the names,
other encodings. Plain CSV has a reader of its own, which names the cell that is wrong."""

from __future__ import annotations

import codecs
import csv
import io
import re
from pathlib import Path

import numpy as np

from pa10d.common.errors import UserError
from pa10d.readers import decimals, echoed, labview, vectors
from pa10d.readers.moments import seconds_since_first
from pa10d.readers.packed import DAMAGED, unpacked
from pa10d.readers.table import ForeignTable
from pa10d.store.channels import Array
from pa10d.store.column_guess import tells_time
from pa10d.store.column_mapping import UNITS
from pa10d.store.csv_locate import is_comment, most_unpacked

DELIMITERS = (";", "\t", "|", ",")
FINE = {
    "nanosec": 1e-9, "nsec": 1e-9, "nsecs": 1e-9, "nanosecs": 1e-9, "usec": 1e-6, "usecs": 1e-6,
    "microsec": 1e-6,
}  # fmt: skip
"""What stands beside whole seconds, in a column of its own."""
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


def read_text(path: Path) -> ForeignTable:
    """Every column that holds numbers, and what stands for them."""
    text = _decoded(path)
    lines = labview.bare_table(text.splitlines())
    by_rostopic = bool(lines) and echoed.by_rostopic(lines[0])
    lines[:1] = [echoed.bare_header(line) for line in lines[:1]]
    comments = 0
    while comments < len(lines) and is_comment(lines[comments]):
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
    first = _cells(body[0], delimiter)
    names = echoed.by_ros2_topic([_cells(line, delimiter) for line in body[:2]])
    from_ros2 = bool(names)
    bare = from_ros2 or all(map(decimals.is_number, first))
    units: list[str] = []
    if bare and not from_ros2:
        names, units = _names_above(lines[:comments], delimiter, len(first))
    elif not bare:
        names, body = _in_levels(first, body[1:], delimiter)
        units = _units(body[0], delimiter, len(names)) if body else []
        body = body[1:] if units else body
    named = [f"{name}[{unit}]" if unit else name for name, unit in _paired(names, units)]
    _refuse_twice(path, named, len(lines) - len(body))
    below = len(lines) - len(body) + 1
    nameless = bare and names[:1] == ["c1"]
    remarks = [f"no header: columns are called c1 … {names[-1]}"] if nameless else []
    if from_ros2:
        remarks = ["rows of ros2 topic echo --csv, of sensor_msgs/JointState by their shape"]
    if above:
        remarks.append(f"{above} {'line' if above == 1 else 'lines'} above the header left out")
    found, words = _columns(path, body, named, delimiter, below)
    found, words = echoed.by_their_names(path, found, words)
    if by_rostopic:
        found = echoed.of_rostopic(found)
        words.pop("field.header.frame_id", None)
    of_vectors, told = vectors.out_of_cells(path, words)
    found |= of_vectors
    left = [
        name for name in words
        if name not in told and not (from_ros2 and name.startswith(echoed.WORDS))
    ]  # fmt: skip
    if left:
        remarks.append(f"no numbers in {', '.join(left)}: left out")
    return ForeignTable(found, remarks)


def _in_levels(names: list[str], body: list[str], delimiter: str) -> tuple[list[str], list[str]]:
    """Names in two rows, as a data frame with levels of columns writes them: what a value is, and
    of which joint. Below them it may name its index. With the rows that are left."""
    below = [_cells(line, delimiter) for line in body[:2]]
    if not repeats(names) or not below or not _may_be_names(below[0], len(names)):
        return names, body
    joined = [".".join(filter(None, pair)) for pair in zip(names, below[0], strict=True)]
    if below[1:] and below[1][0] and not any(below[1][1:]):
        return [below[1][0], *joined[1:]], body[2:]
    return joined, body[1:]


def _may_be_names(cells: list[str], count: int) -> bool:
    return len(cells) == count and not any(map(decimals.is_number, cells))


def repeats(names: list[str]) -> bool:
    """Whether a name stands over two columns."""
    named = [name for name in names if name]
    return len({*named}) < len(named)


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
    found = [decimals.is_number(cell) for cell in cells if cell]
    return 2 * sum(found) > len(found)


def numbers(cells: list[str]) -> bool:
    """Whether this is a row of samples, not of names."""
    return all(decimals.Style().number(cell) is not None for cell in cells)


def stamps_in_two(names: list[str]) -> list[tuple[str, str, float]]:
    """Columns of seconds, each with the one that has the rest, and what one of that is in s."""
    out = []
    written = {name.lower(): name for name in names}
    for sec in names:
        before, dot, end = sec.lower().rpartition(".")
        if end in ("sec", "secs"):
            fine = ((f"{before}{dot}{word}", unit) for word, unit in FINE.items())
            out += [(sec, written[name], unit) for name, unit in fine if name in written][:1]
    return out


def units_or_moments(line: str) -> bool:
    """Whether the row below the names holds their units, or stamps that are no numbers."""
    cells = _cells(line, ",")
    moments = any(":" in cell and seconds_since_first([cell]) is not None for cell in cells)
    return moments or bool(_units(line, ",", len(cells)))


def _decoded(path: Path) -> str:
    most = most_unpacked(path)
    try:
        with unpacked(path) as file:
            raw = file.read(most + 1)
    except DAMAGED as error:
        raise UserError(f"{path}: the packed data are damaged; expected a whole file") from error
    if len(raw) > most:
        raise UserError(f"{path}: becomes more than {most} bytes of text; expected a recording")
    if (form := _wide(raw)) is not None:
        return raw.decode(form, "replace").removeprefix("\ufeff")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in raw[:LOOK]:
            raise UserError(
                f"{path}: neither text nor a format that is known; expected CSV, a ROS 2 bag "
                "(.db3, .mcap), Parquet, MAT, .npz or a CAN log"
            ) from None
        return raw.decode("latin-1")


def _wide(raw: bytes) -> str | None:
    """The encoding of text whose letters have several bytes, said by its mark or by its zeros."""
    if raw.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        return "utf-32"
    if raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    head = raw[:200]
    if len(head) >= 20 and not head[0] and not any(head[::2]):
        return "utf-16-be"
    if len(head) >= 20 and head[0] and not any(head[1::2]):
        return "utf-16-le"
    return None


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


def _names_above(comments: list[str], delimiter: str, count: int) -> tuple[list[str], list[str]]:
    """The last comment that names as many columns, and their units where the one below it has
    those; else c1 … for ``--map``."""
    units: list[str] = []
    for line in reversed(comments):
        bare = line.lstrip().lstrip("#%/").strip()
        for sign in (delimiter, ",", " "):
            cells = [c for c in _cells(bare, sign) if c] if bare else []
            if len(cells) != count:
                continue
            if units or not (found := _units(bare, sign, count)):
                return cells, units
            units = found
            break
    return [f"c{k + 1}" for k in range(count)], []


def _units(line: str, delimiter: str, count: int) -> list[str]:
    cells = [cell.strip("[]() ") for cell in _cells(line, delimiter)]
    cells = [cell if cell in UNITS else SPELT.get(cell, SPELT.get(cell.lower(), cell))
             for cell in cells]  # fmt: skip
    known = [cell in UNITS or not cell or cell == "-" for cell in cells]
    numbers = any(map(decimals.is_number, cells))
    return cells if len(cells) == count and all(known) and any(cells) and not numbers else []


def _paired(names: list[str], units: list[str]) -> list[tuple[str, str]]:
    units = units or [""] * len(names)
    return [
        (name, unit if UNITS.get(unit, 1.0) != 1.0 and "[" not in name else "")
        for name, unit in zip(names, units, strict=True)
    ]


def _columns(
    path: Path, body: list[str], names: list[str], delimiter: str, below: int
) -> tuple[dict[str, Array], dict[str, list[str]]]:
    """Numbers, and the cells of the columns that hold none."""
    rows = [
        (below + k, _cells(line, delimiter))
        for k, line in enumerate(body)
        if line.strip() and not is_comment(line)
    ]
    if all(len(cells) == len(names) + 1 and not cells[-1] for _, cells in rows):
        rows = [(line, cells[:-1]) for line, cells in rows]  # a sign behind each value
    for line, cells in rows:
        if len(cells) != len(names):
            last = "; was the file cut off?" if line == rows[-1][0] else ""
            found = f"{path}:{line}: found {len(cells)} columns, expected {len(names)}{last}"
            raise UserError(found)
    columns = [[cells[k] for _, cells in rows] for k in range(len(names))]
    tidy = [decimals.tidy(column) for column in columns]
    try:
        styles = decimals.styles_of(tidy)
    except decimals.Ambiguous as error:
        raise UserError(
            f"{path}: column {error.column + 1} ({names[error.column]}): {error.cell!r} may be "
            "thousands or have decimals; expected one sign before decimals in all columns"
        ) from error
    out: dict[str, Array] = {}
    words: dict[str, list[str]] = {}
    timeless = not any(map(tells_time, names))
    for k, name in enumerate(names):
        values = decimals.values_of(tidy[k], styles[k])
        if all(value is not None for value in values):
            numbers = np.array(values, dtype=np.float64)
            is_clock = not name and not k and timeless and not _counts(numbers)
            out["time" if is_clock else name] = numbers
        elif (stamps := seconds_since_first(columns[k])) is not None:
            out[name if name or "time" in names else "time"] = stamps
        elif sum(value is not None for value in values) > len(values) / 2:
            row = next(i for i, value in enumerate(values) if value is None)
            raise UserError(
                f"{path}:{rows[row][0]}: column {k + 1} ({name}): found {columns[k][row]!r}, "
                "expected a finite number"
            )
        else:
            words[name] = columns[k]
    return out, words


def _counts(values: Array) -> bool:
    """Whether an index is the number of the row and nothing else."""
    return bool((np.diff(values) == 1).all())
