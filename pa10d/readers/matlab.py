"""MATLAB's files: up to v7 by SciPy, v7.3 and other HDF5 by h5py."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.readers.arrays import damaged, spread
from pa10d.readers.packed import first_bytes
from pa10d.readers.table import ForeignTable
from pa10d.readers.weights import NUMBER, refuse_growth, size_of_mat


def read_mat(path: Path, joints: Sequence[str] = ()) -> ForeignTable:
    """Arrays, or a struct of them. joints: the robot's, as ``read_npz`` has them."""
    from scipy.io import loadmat, whosmat

    if is_hdf5(path):
        return _read_hdf5(path, joints)
    try:
        told = sum(NUMBER * math.prod(shape) for _, shape, _ in whosmat(path))
        refuse_growth(path, max(told, size_of_mat(path)))
        with warnings.catch_warnings():  # sparse ones are left out, whatever they are
            warnings.simplefilter("ignore", DeprecationWarning)
            warnings.simplefilter("ignore", FutureWarning)
            content = loadmat(path, simplify_cells=True)
    except UserError:
        raise
    except Exception as error:  # whatever a damaged file makes of SciPy
        raise damaged(path, "a MAT file", error) from error
    named = {k: v for k, v in content.items() if not k.startswith("__")}
    if any(type(value).__name__ == "MatlabOpaque" for value in content.values()):
        raise UserError(
            f"{path}: a MATLAB object (table, timeseries …), which MATLAB alone can unpack; "
            "expected arrays or a struct: table2struct(T, 'ToScalar', true)"
        )
    odd = [place for place, kind in _odd(named) if kind]
    said = [f"no plain numbers in {', '.join(odd)}: left out"] if odd else []
    return ForeignTable(spread(named, said, joints), said)


def is_hdf5(path: Path) -> bool:
    """By its first bytes; MATLAB puts 512 of its own before them."""
    head = first_bytes(path, 1024)
    return b"\x89HDF\r\n\x1a\n" in (head[:8], head[512:520])


def _odd(content: Mapping[str, Any]) -> Iterator[tuple[str, bool]]:
    """Names of what looks like numbers and cannot be read as such."""
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _odd(value)
        elif isinstance(value, np.ndarray):
            yield f"{name} (complex)", value.dtype.kind == "c"
        else:
            yield f"{name} (sparse)", hasattr(value, "tocsc")


def _read_hdf5(path: Path, joints: Sequence[str]) -> ForeignTable:
    try:
        import h5py
    except ImportError as error:
        raise UserError(
            f"{path}: a MAT file of version 7.3 (HDF5), which needs h5py; expected "
            "pip install 'pa10d[matlab]', or a file saved with -v7"
        ) from error
    found: dict[str, Any] = {}
    size = 0

    def visit(name: str, item: Any) -> None:
        nonlocal size
        if "pandas_type" in item.attrs:
            raise UserError(
                f"{path}: a data frame as pandas' to_hdf stores it; expected arrays by name, or "
                "read_hdf(…).to_parquet(…)"
            )
        if not isinstance(item, h5py.Dataset) or name.startswith("#"):
            return
        if item.external or item.is_virtual:
            raise UserError(
                f"{path}: {name}: its values lie in another file; expected a recording that holds "
                "them itself"
            )
        size += item.dtype.itemsize * item.size
        refuse_growth(path, size)
        if h5py.check_string_dtype(item.dtype) and item.ndim == 1:
            found[name.rpartition("/")[2]] = item.asstr()[()].astype(str)
        elif item.dtype.names:
            rows = np.asarray(item[()])
            found.update({field: rows[field] for field in item.dtype.names})
        elif item.dtype.kind in "fiub" and item.attrs.get("MATLAB_class") != b"char":
            *structs, own = name.split("/")
            inner = found
            for struct in structs:
                inner = inner.setdefault(struct, {})
            inner[own] = np.asarray(item[()]).T  # MATLAB counts columns first

    try:
        with h5py.File(path) as file:
            file.visititems(visit)
    except (OSError, MemoryError) as error:
        raise damaged(path, "a MAT or HDF5 file", error) from error
    said: list[str] = []
    return ForeignTable(spread(found, said, joints), said)
