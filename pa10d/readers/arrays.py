"""Files of named arrays: NumPy's, MATLAB's, Arrow's. (N, n) arrays become a column per joint."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.readers.table import Table
from pa10d.readers.text import first_bytes
from pa10d.store.channels import Array

SPELT = {"temperature": "temp", "current": "i", "t": "time"}
"""What our own files, and most others', call a block of columns."""


def read_npz(path: Path) -> Table:
    """Arrays by name; objects are not unpacked."""
    try:
        with path.open("rb") as raw, np.load(raw, allow_pickle=False) as file:
            return Table(spread({name: file[name] for name in file.files}))
    except (OSError, ValueError, zipfile.BadZipFile, KeyError, EOFError) as error:
        raise _damaged(path, "a NumPy .npz of plain arrays", error) from error


def read_mat(path: Path) -> Table:
    """MATLAB up to v7 by SciPy, v7.3 by h5py: arrays, or a struct of them."""
    from scipy.io import loadmat

    if _is_hdf5(path):
        return _read_hdf5(path)
    try:
        content = loadmat(path, simplify_cells=True)
    except Exception as error:  # whatever a damaged file makes of SciPy
        raise _damaged(path, "a MAT file", error) from error
    return Table(spread({k: v for k, v in content.items() if not k.startswith("__")}))


def read_arrow(path: Path) -> Table:
    """Parquet, Feather and Arrow files; lists of equal length become a column per joint."""
    import pyarrow as pa
    from pyarrow import feather, parquet

    try:
        is_parquet = first_bytes(path, 4) == b"PAR1"
        found = parquet.read_table(path) if is_parquet else feather.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise _damaged(path, "a Parquet or Arrow file", error) from error
    return Table(spread({name: _of_arrow(found[name]) for name in found.column_names}))


def spread(content: Mapping[str, Any]) -> dict[str, Array]:
    """Everything that is numbers, flat: ``q`` (N, n) -> q1 … qn, structs by their fields."""
    lengths = [len(v) for _, v in _leaves(content) if v.ndim]
    length = max(lengths, default=0)
    out: dict[str, Array] = {}
    for name, values in _leaves(content):
        block = values[:, None] if values.ndim == 1 else values
        if block.ndim != 2:
            continue
        if len(block) != length and block.shape[1] == length:
            block = block.T
        if len(block) != length:
            continue
        called = SPELT.get(name, name)
        if block.shape[1] == 1:
            lone = called in ("q", "tau", "dq", "temp", "i")
            out[f"{called}1" if lone else called] = np.ascontiguousarray(block[:, 0])
        else:
            out |= {f"{called}{j + 1}": column for j, column in enumerate(block.T)}
    return out


def _leaves(content: Mapping[str, Any], within: str = "") -> Iterator[tuple[str, Array]]:
    for name, value in content.items():
        if isinstance(value, Mapping):
            prefix = {"extra": "", "command": "cmd_"}.get(name, "")
            yield from _leaves(value, prefix)
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and value.size > 1:
            yield f"{within}{name}", np.squeeze(value.astype(np.float64))


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


def _is_hdf5(path: Path) -> bool:
    head = first_bytes(path, 1024)
    return b"\x89HDF\r\n\x1a\n" in (head[:8], head[512:520])


def _read_hdf5(path: Path) -> Table:
    try:
        import h5py
    except ImportError as error:
        raise UserError(
            f"{path}: a MAT file of version 7.3, which needs h5py; expected "
            "pip install 'pa10d[matlab]', or a file saved with -v7"
        ) from error
    found: dict[str, Array] = {}

    def visit(name: str, item: Any) -> None:
        if (
            isinstance(item, h5py.Dataset)
            and item.dtype.kind in "fiub"
            and not name.startswith("#")
        ):
            found[name.rpartition("/")[2]] = np.asarray(item[()]).T  # MATLAB counts columns first

    try:
        with h5py.File(path) as file:
            file.visititems(visit)
    except OSError as error:
        raise _damaged(path, "a MAT file", error) from error
    return Table(spread(found))


def _damaged(path: Path, expected: str, error: Exception) -> UserError:
    said = (str(error).strip() or type(error).__name__).splitlines()[0][:120]
    return UserError(f"{path}: cannot be read ({said}); expected {expected}")
