"""Files of named arrays: NumPy's, MATLAB's, Arrow's. (N, n) arrays become a column per joint."""

from __future__ import annotations

import math
import re
import struct
import warnings
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.readers.packed import first_bytes
from pa10d.readers.signatures import STREAM
from pa10d.readers.table import ForeignTable
from pa10d.readers.weights import (
    NUMBER,
    refuse_growth,
    size_of_arrow,
    size_of_mat,
    size_of_parquet,
)
from pa10d.store.channels import Array

SPELT = {"temperature": "temp", "current": "i", "t": "time"}
"""What our own files, and most others', call a block of columns."""
SECOND = 1_000_000_000  # ns
NOT_NUMPY = (OSError, ValueError, zipfile.BadZipFile, zlib.error, KeyError, EOFError, MemoryError)
FEW = 20  # rows: fewer are names, gains and the like
CLOCKS = ("time", "t", "timestamp", "timestamps", "stamp")
PREFIXES = {"extra": "", "command": "cmd_"}
"""Structs of our own files whose fields are called by more, or less, than their own names."""
Place = tuple[str, ...]
_JOINTS = re.compile(r"joint|name|motor|axis|axes|actuator", re.I)
"""What a list of joints' names is called."""


def read_npz(path: Path, joints: Sequence[str] = ()) -> ForeignTable:
    """Arrays by name, also one array of records; objects are not unpacked. joints: the robot's, by
    which columns are ordered where names of joints lie beside the arrays; likewise below."""
    try:
        refuse_growth(path, _size_of_npz(path))
        with path.open("rb") as raw:
            found = np.load(raw, allow_pickle=False)
            if isinstance(found, np.ndarray):
                return ForeignTable(spread(_of_one(found)))
            with found as file:
                said: list[str] = []
                content = {name: file[name] for name in file.files}
                return ForeignTable(spread(content, said, joints), said)
    except NOT_NUMPY as error:
        raise damaged(path, "a NumPy .npz of plain arrays", error) from error


def _size_of_npz(path: Path) -> int:
    """Bytes of its arrays, as the archive says; a plain array is as large as its file."""
    if not zipfile.is_zipfile(path):
        return 0
    with zipfile.ZipFile(path) as archive:
        return sum(part.file_size for part in archive.infolist())


def _of_one(found: Array) -> Mapping[str, Any]:
    """A .npy file: records by their fields, a table by columns without names."""
    if found.dtype.names:
        return {"": found}
    table = np.atleast_2d(found.T if found.ndim == 1 else found)
    return {f"c{k + 1}": column for k, column in enumerate(table.T)}


def read_mat(path: Path, joints: Sequence[str] = ()) -> ForeignTable:
    """MATLAB up to v7 by SciPy, v7.3 by h5py: arrays, or a struct of them."""
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


def _odd(content: Mapping[str, Any]) -> Iterator[tuple[str, bool]]:
    """Names of what looks like numbers and cannot be read as such."""
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _odd(value)
        elif isinstance(value, np.ndarray):
            yield f"{name} (complex)", value.dtype.kind == "c"
        else:
            yield f"{name} (sparse)", hasattr(value, "tocsc")


def read_arrow(path: Path) -> ForeignTable:
    """Parquet, Feather and Arrow files; lists of equal length become a column per joint."""
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
    columns: dict[str, Any] = {}
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


def spread(
    content: Mapping[str, Any], said: list[str] | None = None, joints: Sequence[str] = ()
) -> dict[str, Array]:
    """Everything that is numbers, flat: ``q`` (N, n) -> q1 … qn, structs by their fields.

    Fields that are called alike in two structs keep the structs' names: ``measured.q1``. said: is
    told what is left out because it is not as long as the others, and what names decided. joints:
    the robot's.
    """
    order = _order(_named_joints(content, joints), joints, said)
    leaves = _of_one_clock(list(_leaves(content)))
    length = _samples_in(leaves)
    if said is not None:
        said += [
            f"{'.'.join(place)} has {' x '.join(map(str, v.shape))} numbers for {length} samples: "
            "left out"
            for place, v in leaves
            if v.ndim and max(v.shape) > FEW and _rows(v, length) is None
        ]
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
            places = order if len(order) == block.shape[1] else range(1, block.shape[1] + 1)
            named = sorted(zip(places, range(block.shape[1]), strict=True))
            out |= {f"{called}{place}": block[:, j] for place, j in named}
    return out


def _named_joints(content: Mapping[str, Any], joints: Sequence[str]) -> list[str]:
    """The only list of different words in it that are the robot's joints, or, where there is none,
    that is called like names of joints. It may stand beside each of the signals."""
    lists = [
        (name, tuple(str(word).strip() for word in np.ravel(values)))
        for name, values in _words(content)
    ]
    own = {words for _, words in lists if {*words} == {*joints}}
    called = {words for name, words in lists if _JOINTS.search(name)}
    whole = [words for words in own or called if len({*words}) == len(words) > 1]
    return [*whole[0]] if len(whole) == 1 else []


def _words(content: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _words(value)
        elif isinstance(value, np.ndarray) and value.dtype.kind in "UO" and value.size:
            words = [one for one in np.ravel(value) if isinstance(one, str)]
            if len(words) == value.size:
                yield name, value


def _order(names: Sequence[str], joints: Sequence[str], said: list[str] | None) -> list[int]:
    """Each name's joint from 1, where they are the robot's; else nothing, and it is said."""
    known = [name.strip() for name in names]
    if not joints or len(known) != len(joints):
        return []
    if {*known} != {*joints}:
        if said is not None:
            said.append(f"joints are called {', '.join(known)}: taken in this order")
        return []
    order = [joints.index(name) + 1 for name in known]
    if said is not None and order != sorted(order):
        said.append(f"joints stand in the order {', '.join(known)}: dealt out by their names")
    return order


def _of_one_clock(leaves: Sequence[tuple[Place, Array]]) -> list[tuple[Place, Array]]:
    """Signals that are stored with a clock each, which all say the same: one is enough."""
    clocks = [(place, v) for place, v in leaves if place[-1].lower() in CLOCKS and v.ndim == 1]
    if len(clocks) < 2 or not all(np.array_equal(clocks[0][1], v) for _, v in clocks[1:]):
        return list(leaves)
    twice = {place for place, _ in clocks[1:]}
    return [(place, v) for place, v in leaves if place not in twice]


def _called(place: Place) -> str:
    """By the last name alone, as far as nobody else is called so."""
    name = f"{PREFIXES.get(place[-2], '')}{place[-1]}" if len(place) > 1 else place[-1]
    return SPELT.get(name, name)


def _samples_in(leaves: Sequence[tuple[Place, Array]]) -> int:
    """As many as there are stamps; without any as the longest array has."""
    clocks = [len(v) for place, v in leaves if place[-1].lower() in CLOCKS and v.ndim == 1]
    return max(clocks or [max(v.shape) for _, v in leaves if v.ndim], default=0)


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
        elif isinstance(value, np.ndarray) and value.dtype.kind in "mM" and value.size > 1:
            yield place, _seconds(np.squeeze(value))
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and value.size > 1:
            yield place, np.squeeze(value.astype(np.float64))


def _seconds(moments: Any) -> Array:
    """Since the first whole second, of NumPy's dates and spans; none of them is nan."""
    fine = moments.astype("M8[ns]" if moments.dtype.kind == "M" else "m8[ns]")
    ns = fine.astype(np.int64)
    seconds = (ns - ns.flat[0] // SECOND * SECOND) * 1e-9
    return np.where(np.isnat(fine), np.nan, seconds)


def _listed(name: str, values: Any) -> dict[str, Any]:
    """An array of structs: each by its number, Simulink's signals and those of its data sets
    by their labels."""
    each = list(np.ravel(np.asarray(values, dtype=object)))
    if (rows := _one_a_sample(each)) is not None:
        return rows
    out: dict[str, Any] = {}
    for k, value in enumerate(each, 1):
        if isinstance(value, Mapping):
            label = str(value.get("label") or value.get("Name") or "")
            out[label or f"{name}{k}"] = value.get("values", value)
    return out


def _one_a_sample(structs: Sequence[Any]) -> dict[str, Any] | None:
    """(N, k) by field, of as many structs as there are samples, all alike and of a few numbers
    each; None where they are something else."""
    if len(structs) <= FEW or not all(isinstance(one, Mapping) for one in structs):
        return None
    shapes = {tuple((k, np.shape(v)) for k, v in one.items()) for one in structs}
    if len(shapes) != 1 or any(len(shape) > 1 for _, shape in next(iter(shapes))):
        return None
    stacked = {name: np.array([one[name] for one in structs]) for name in structs[0]}
    return {name: v for name, v in stacked.items() if v.dtype.kind in "fiub"}


def _of_arrow(column: Any) -> Any:
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


def is_hdf5(path: Path) -> bool:
    """By its first bytes; MATLAB puts 512 of its own before them."""
    head = first_bytes(path, 1024)
    return b"\x89HDF\r\n\x1a\n" in (head[:8], head[512:520])


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


def damaged(path: Path, expected: str, error: Exception) -> UserError:
    said = (str(error).strip() or type(error).__name__).splitlines()[0][:120]
    return UserError(f"{path}: cannot be read ({said}); expected {expected}")
