"""Parquet, Feather and Arrow files."""

from __future__ import annotations

import struct
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.readers.arrays import CLOCKS, SECOND, damaged, spread
from pa10d.readers.packed import first_bytes
from pa10d.readers.signatures import STREAM
from pa10d.readers.table import ForeignTable
from pa10d.readers.weights import refuse_growth, size_of_arrow, size_of_parquet
from pa10d.store.channels import Array


def read_arrow(path: Path) -> ForeignTable:
    """Lists of equal length become a column per joint."""
    import pyarrow as pa
    from pyarrow import feather, parquet

    try:
        is_parquet = first_bytes(path, 4) == b"PAR1"
        if not is_parquet:
            refuse_growth(path, size_of_arrow(path))
        if is_parquet:
            refuse_growth(path, size_of_parquet(parquet.read_metadata(path)))
            found = parquet.read_table(path)
        elif first_bytes(path, 4) == STREAM:
            with pa.OSFile(str(path)) as source, pa.ipc.open_stream(source) as stream:
                found = stream.read_all()
        else:
            found = feather.read_table(path)
    except (pa.ArrowException, OSError, struct.error, ValueError, IndexError) as error:
        raise damaged(path, "a Parquet or Arrow file", error) from error
    columns = spread_arrow(path, found)
    moments = [name for name in found.column_names if _is_moment(found[name].type)]
    if len(moments) == 1 and not any(name.lower() in CLOCKS for name in columns):
        columns = {"time": columns.pop(moments[0]), **columns}  # the index of a data frame
    return ForeignTable(columns, _without_numbers(found))


def spread_arrow(path: Path, found: Any) -> dict[str, Array]:
    """An Arrow table's columns, as far as they are numbers; lists by the names beside them."""
    while any(_is_struct(kind) for kind in found.schema.types):
        found = found.flatten()
    twice = [name for name, count in Counter(found.column_names).items() if count > 1]
    if twice:
        raise UserError(f"{path}: two columns are called {twice[0]!r}; expected one")
    names = _names_beside(path, found)
    columns: dict[str, Array | None] = {}
    for name in found.column_names:
        try:
            values = _of_arrow(found[name])
        except ValueError as error:
            raise UserError(f"{path}: column {name}: {error}") from error
        if names and values is not None and values.ndim == 2 and values.shape[1] == len(names):
            columns |= {f"{name}.{joint}": values[:, k] for k, joint in enumerate(names)}
        else:
            columns[name] = values
    return spread(columns)


def _is_struct(kind: Any) -> bool:
    import pyarrow as pa

    return bool(pa.types.is_struct(kind))


def _names_beside(path: Path, found: Any) -> list[str]:
    """What a column of names, such as that of sensor_msgs/JointState, calls the values of each
    row's lists; nothing where there is none. UserError where the rows differ."""
    import pyarrow as pa

    for name in found.column_names:
        kind = found[name].type
        listed = pa.types.is_list(kind) or pa.types.is_large_list(kind)
        if not listed or not (
            pa.types.is_string(kind.value_type) or pa.types.is_large_string(kind.value_type)
        ):
            continue
        rows = found[name].to_pylist()
        other = next((k for k, row in enumerate(rows) if row != rows[0]), None)
        if other is not None:
            raise UserError(
                f"{path}: column {name}: row {other + 1} names {rows[other]}, the first "
                f"{rows[0]}; expected one order in all rows"
            )
        if rows and rows[0] and len({*rows[0]}) == len(rows[0]):
            return [str(one) for one in rows[0]]
    return []


def _is_moment(kind: Any) -> bool:
    import pyarrow as pa

    return bool(pa.types.is_timestamp(kind) or pa.types.is_duration(kind))


def _without_numbers(found: Any) -> list[str]:
    """Words may stand for numbers, and it is not for us to say which."""
    import pyarrow as pa

    words = (
        pa.types.is_string,
        pa.types.is_large_string,
        pa.types.is_binary,
        pa.types.is_dictionary,
    )
    kinds = {name: found[name].type for name in found.column_names}
    left = [f"{name} ({kind})" for name, kind in kinds.items() if any(a(kind) for a in words)]
    return [f"no numbers in {', '.join(left)[:120]}: left out"] if left else []


def _of_arrow(column: Any) -> Array | None:
    import pyarrow as pa

    kind = column.type
    if pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind) or pa.types.is_large_list(kind):
        return _of_lists(column)
    if _is_moment(kind):
        exact = pa.timestamp("ns") if pa.types.is_timestamp(kind) else pa.duration("ns")
        stamps = column.cast(exact).cast(pa.int64())
        if stamps.null_count or not len(stamps):
            return stamps.cast(pa.float64(), safe=False).to_numpy() * 1e-9
        whole = stamps.to_numpy()
        return (whole - whole[0] // SECOND * SECOND) * 1e-9
    numbers = (pa.types.is_integer, pa.types.is_floating, pa.types.is_boolean, pa.types.is_decimal)
    if any(is_one(kind) for is_one in numbers):
        return column.cast(pa.float64(), safe=False).to_numpy()  # ns since 1970 to 0.3 µs
    return None


def _of_lists(column: Any) -> Array | None:
    """(N, k) of rows with k values each; None where they are no numbers; ValueError where the rows
    differ."""
    import pyarrow as pa
    import pyarrow.compute as pc

    inner = column.type.value_type
    if not (pa.types.is_integer(inner) or pa.types.is_floating(inner)):
        return None
    if not len(column):
        return np.empty((0, 1))
    lengths = np.array([-1 if n is None else n for n in pc.list_value_length(column).to_pylist()])
    other = np.flatnonzero((lengths != lengths[0]) | (lengths < 0))
    if len(other):
        row = int(other[0])
        there = "none" if lengths[row] < 0 else f"{lengths[row]} values"
        raise ValueError(f"row {row + 1} has {there}, expected as many in every row")
    flat = pa.concat_arrays([part.flatten() for part in column.chunks]).cast(pa.float64())
    return np.asarray(flat.to_numpy(zero_copy_only=False)).reshape(len(column), -1)
