"""Cells that hold a vector each, as data frames of messages are written: ``"[0.1, -0.2, …]"``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from pa10d.common.errors import UserError
from pa10d.store.channels import Array

_VECTOR = re.compile(r"(?:array)?\(?([\[(].*[\])])\)?")
_OF_NUMPY = re.compile(r"np\.float\d+\(([^)]*)\)")
_BETWEEN = re.compile(r"[\s,;]+")


def is_vector(cell: str) -> bool:
    """Whether a cell holds values in brackets."""
    return bool(_VECTOR.fullmatch(cell.strip()))


def out_of_cells(
    path: Path, words: Mapping[str, Sequence[str]]
) -> tuple[dict[str, Array], list[str]]:
    """Columns of single numbers, and the names of those that became such or told their names.

    words: the cells of columns that hold no numbers. A column of names, the same in every row, says
    what the values beside it are called; else they are numbered from 1. UserError where the rows
    of a column differ in length.
    """
    split = {name: [_parts(cell) for cell in cells] for name, cells in words.items()
             if cells and all(map(is_vector, cells))}  # fmt: skip
    numbers = {name: found for name, rows in split.items() if (found := _numbers(rows)) is not None}
    named = {name: rows[0] for name, rows in split.items() if name not in numbers}
    for name, first in named.items():
        _refuse_another_order(path, name, first, split[name])
    called = list(named.values())
    out: dict[str, Array] = {}
    for name, rows in numbers.items():
        width = len(rows[0])
        other = next((k for k, row in enumerate(rows) if len(row) != width), None)
        if other is not None:
            raise UserError(
                f"{path}: column {name}: sample {other + 1} has {len(rows[other])} values, the "
                f"first {width}; expected as many in every row"
            )
        names = next((one for one in called if len({*one}) == width == len(one)), None)
        ends = [f".{one}" for one in names] if names else [str(k + 1) for k in range(width)]
        out |= {f"{name}{end}": column for end, column in zip(ends, np.array(rows).T, strict=True)}
    return out, [*split]


def _parts(cell: str) -> list[str]:
    inside = _OF_NUMPY.sub(r"\1", cell).strip().removeprefix("array").strip("[]() ")
    return [part.strip("'\"") for part in _BETWEEN.split(inside) if part]


def _numbers(rows: Sequence[Sequence[str]]) -> list[list[float]] | None:
    try:
        return [[float(part) for part in row] for row in rows]
    except ValueError:
        return None


def _refuse_another_order(
    path: Path, name: str, first: list[str], rows: Sequence[list[str]]
) -> None:
    other = next((k for k, row in enumerate(rows) if row != first), None)
    if other is not None:
        raise UserError(
            f"{path}: column {name}: row {other + 1} names {rows[other]}, the first {first}; "
            "expected one order in all rows"
        )
