"""Files of named arrays: NumPy's, MATLAB's, Arrow's. (N, n) arrays become a column per joint."""

from __future__ import annotations

import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.readers.packed import first_bytes
from pa10d.readers.signatures import STREAM
from pa10d.readers.table import Table
from pa10d.store.channels import Array

SPELT = {"temperature": "temp", "current": "i", "t": "time"}
"""What our own files, and most others', call a block of columns."""
CLOCKS = ("time", "t", "timestamp", "stamp")
PREFIXES = {"extra": "", "command": "cmd_"}
"""Structs of our own files whose fields are called by more, or less, than their own names."""
Place = tuple[str, ...]


def read_npz(path: Path) -> Table:
    """Arrays by name, also one array of records; objects are not unpacked."""
    try:
        with path.open("rb") as raw:
            found = np.load(raw, allow_pickle=False)
            if isinstance(found, np.ndarray):
                return Table(spread(_of_one(found)))
            with found as file:
                return Table(spread({name: file[name] for name in file.files}))
    except (OSError, ValueError, zipfile.BadZipFile, KeyError, EOFError) as error:
        raise damaged(path, "a NumPy .npz of plain arrays", error) from error


def _of_one(found: Array) -> Mapping[str, Any]:
    """A .npy file: records by their fields, a table by columns without names."""
    if found.dtype.names:
        return {"": found}
    table = np.atleast_2d(found.T if found.ndim == 1 else found)
    return {f"c{k + 1}": column for k, column in enumerate(table.T)}


def read_mat(path: Path) -> Table:
    """MATLAB up to v7 by SciPy, v7.3 by h5py: arrays, or a struct of them."""
    from scipy.io import loadmat

    if is_hdf5(path):
        return _read_hdf5(path)
    try:
        content = loadmat(path, simplify_cells=True)
    except Exception as error:  # whatever a damaged file makes of SciPy
        raise damaged(path, "a MAT file", error) from error
    named = {k: v for k, v in content.items() if not k.startswith("__")}
    if any(type(value).__name__ == "MatlabOpaque" for value in content.values()):
        raise UserError(
            f"{path}: a MATLAB object (table, timeseries …), which MATLAB alone can unpack; "
            "expected arrays or a struct: table2struct(T, 'ToScalar', true)"
        )
    return Table(spread(named))


def read_arrow(path: Path) -> Table:
    """Parquet, Feather and Arrow files; lists of equal length become a column per joint."""
    import pyarrow as pa
    from pyarrow import feather, parquet

    try:
        is_parquet = first_bytes(path, 4) == b"PAR1"
        if is_parquet:
            found = parquet.read_table(path)
        elif first_bytes(path, 4) == STREAM:
            with pa.OSFile(str(path)) as source, pa.ipc.open_stream(source) as stream:
                found = stream.read_all()
        else:
            found = feather.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise damaged(path, "a Parquet or Arrow file", error) from error
    return Table(spread_arrow(path, found))


def spread_arrow(path: Path, found: Any) -> dict[str, Array]:
    """An Arrow table's columns, as far as they are numbers."""
    return spread({name: _of_arrow(found[name]) for name in found.column_names})


def spread(content: Mapping[str, Any]) -> dict[str, Array]:
    """Everything that is numbers, flat: ``q`` (N, n) -> q1 … qn, structs by their fields.

    Fields that are called alike in two structs keep the structs' names: ``measured.q1``.
    """
    leaves = list(_leaves(content))
    length = _samples_in(leaves)
    blocks = [(place, found) for place, v in leaves if (found := _rows(v, length)) is not None]
    alike = Counter(_called(place) for place, _ in blocks)
    out: dict[str, Array] = {}
    for place, block in blocks:
        called = _called(place)
        if alike[called] > 1:
            called = ".".join(part for part in place if part)
        if block.shape[1] == 1:
            lone = called in ("q", "tau", "dq", "temp", "i")
            out[f"{called}1" if lone else called] = np.ascontiguousarray(block[:, 0])
        else:
            out |= {f"{called}{j + 1}": column for j, column in enumerate(block.T)}
    return out


def _called(place: Place) -> str:
    """By the last name alone, as far as nobody else is called so."""
    name = f"{PREFIXES.get(place[-2], '')}{place[-1]}" if len(place) > 1 else place[-1]
    return SPELT.get(name, name)


def _samples_in(leaves: Sequence[tuple[Place, Array]]) -> int:
    """As many as there are stamps; without any as the longest array has."""
    clocks = [len(v) for place, v in leaves if place[-1].lower() in CLOCKS and v.ndim == 1]
    return max(clocks or [len(v) for _, v in leaves if v.ndim], default=0)


def _rows(values: Array, length: int) -> Array | None:
    """(length, k), whichever way round it was; None for what is something else."""
    block = values[:, None] if values.ndim == 1 else values
    if block.ndim != 2:
        return None
    if len(block) != length and block.shape[1] == length:
        block = block.T
    return block if len(block) == length else None


def _leaves(content: Mapping[str, Any], within: Place = ()) -> Iterator[tuple[Place, Array]]:
    for name, value in content.items():
        place = (*within, name)
        if isinstance(value, Mapping):
            yield from _leaves(value, place)
        elif isinstance(value, np.ndarray) and value.dtype.names:
            fields = {field: value[field] for field in value.dtype.names}
            yield from _leaves(fields, place)
        elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype.hasobject):
            yield from _leaves(_listed(name, value), place)
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and value.size > 1:
            yield place, np.squeeze(value.astype(np.float64))


def _listed(name: str, values: Any) -> dict[str, Any]:
    """An array of structs: each by its number, Simulink's signals by their labels."""
    out: dict[str, Any] = {}
    for k, value in enumerate(np.ravel(np.asarray(values, dtype=object)), 1):
        if isinstance(value, Mapping):
            label = str(value.get("label") or "")
            out[label or f"{name}{k}"] = value.get("values", value)
    return out


def _of_arrow(column: Any) -> Any:
    import pyarrow as pa

    kind = column.type
    if pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind):
        return np.array(column.to_pylist(), dtype=np.float64)
    if pa.types.is_timestamp(kind):
        return column.cast(pa.timestamp("ns")).cast(pa.int64()).to_numpy() * 1e-9
    if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind):
        return column.cast(pa.float64()).to_numpy()
    return None


def is_hdf5(path: Path) -> bool:
    """By its first bytes; MATLAB puts 512 of its own before them."""
    head = first_bytes(path, 1024)
    return b"\x89HDF\r\n\x1a\n" in (head[:8], head[512:520])


def _read_hdf5(path: Path) -> Table:
    try:
        import h5py
    except ImportError as error:
        raise UserError(
            f"{path}: a MAT file of version 7.3 (HDF5), which needs h5py; expected "
            "pip install 'pa10d[matlab]', or a file saved with -v7"
        ) from error
    found: dict[str, Any] = {}

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith("#"):
            return
        if item.dtype.kind in "fiub" and item.attrs.get("MATLAB_class") != b"char":
            *structs, own = name.split("/")
            inner = found
            for struct in structs:
                inner = inner.setdefault(struct, {})
            inner[own] = np.asarray(item[()]).T  # MATLAB counts columns first

    try:
        with h5py.File(path) as file:
            file.visititems(visit)
    except OSError as error:
        raise damaged(path, "a MAT or HDF5 file", error) from error
    return Table(spread(found))


def damaged(path: Path, expected: str, error: Exception) -> UserError:
    said = (str(error).strip() or type(error).__name__).splitlines()[0][:120]
    return UserError(f"{path}: cannot be read ({said}); expected {expected}")
