"""Finds the line and column at which a CSV file is broken: slow, only used once it is."""

from __future__ import annotations

import csv
import gzip
import math
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.measurement.believable import EXPECTED, believable

LARGEST = 4 << 30  # bytes of a recording as text
SMALL, RATIO = 64 << 20, 200  # bytes; times the compressed size
COMMENT = ("#", "%", "//")
"""What a line that is no row begins with."""
GZIP = b"\x1f\x8b"


def is_gzip(path: Path) -> bool:
    """By content, whatever the file is called."""
    with path.open("rb") as file:
        return file.read(2) == GZIP


def refuse_bombs(path: Path) -> None:
    """UserError where a compressed file would become more than a recording ever is."""
    if not path.is_file() or not is_gzip(path):
        return
    packed = path.stat().st_size
    most, size = most_unpacked(path), 0
    with gzip.open(path) as file:
        try:
            while part := file.read(1 << 20):
                size += len(part)
                if size > most:
                    raise UserError(
                        f"{path}: {packed} compressed bytes become more than {most}; expected a "
                        "recording, which is a tenth or a twentieth of its size when compressed"
                    )
        except (OSError, EOFError, zlib.error):
            return  # said with the line at which it ends


def most_unpacked(path: Path) -> int:
    """Bytes that a recording in this file may become."""
    return min(LARGEST, max(SMALL, RATIO * path.stat().st_size))


def lines(path: Path) -> Iterator[str]:
    """The file's lines as text; UserError where one is none."""
    number = 0
    with gzip.open(path) if is_gzip(path) else path.open("rb") as file:
        try:
            for number, line in enumerate(file, start=1):
                yield line.decode("utf-8-sig" if number == 1 else "utf-8")
        except UnicodeDecodeError as error:
            byte = error.object[error.start]
            raise UserError(
                f"{path}:{number}: byte 0x{byte:02x} is not UTF-8; expected a text file"
            ) from error
        except (OSError, EOFError, zlib.error) as error:
            raise UserError(
                f"{path}:{number + 1}: the compressed data end or are damaged here; "
                "expected a whole .gz file"
            ) from error


def is_comment(line: str) -> bool:
    """Whether a line is a remark on what stands around it."""
    return line.lstrip().startswith(COMMENT)


def rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """(line, cells) of every row that is neither empty nor a comment."""
    reader = csv.reader(lines(path), skipinitialspace=True)
    try:
        for cells in reader:
            if cells and not (reader.line_num > 1 and is_comment(cells[0])):
                yield reader.line_num, cells
    except csv.Error as error:
        raise UserError(
            f"{path}:{reader.line_num}: {error}; expected comma-separated cells"
        ) from error


def first_fault(path: Path, names: Sequence[str], required: Sequence[int]) -> str | None:
    """What is wrong first: a row of another length, or a required cell that is no number."""
    table = rows(path)
    next(table, None)
    for line, cells in table:
        if len(cells) != len(names):
            last = "; was the file cut off?" if next(table, None) is None else ""
            return f"{path}:{line}: found {len(cells)} columns, expected {len(names)}{last}"
        for k in required:
            if (found := _fault(cells[k])) is not None:
                column = f"column {k + 1} ({names[k]})"
                return f"{path}:{line}: {column}: found {found}, expected {EXPECTED}"
    return None


def line_of_row(path: Path, row: int) -> int:
    """The line in which data row ``row`` (from 0, header not counted) stands."""
    return next((line for k, (line, _) in enumerate(rows(path)) if k == row + 1), 0)


def _fault(cell: str) -> str | None:
    text = cell.strip()
    if not text:
        return "an empty cell"
    try:
        value = float(text) if "_" not in text else math.nan
    except ValueError:
        return repr(text if len(text) <= 40 else text[:37] + "...")
    return None if believable(value) else repr(text)
