"""Named arrays of any file as a table: (N, n) becomes a column per joint; and NumPy's own files."""

from __future__ import annotations

import re
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.readers.table import ForeignTable
from pa10d.readers.weights import refuse_growth
from pa10d.store.channels import Array
from pa10d.store.column_mapping import SPELT

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
    """Arrays by name, also one array of records; objects are not unpacked. joints: the robot's,
    by which columns are ordered where names of joints lie beside the arrays."""
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


def _listed(name: str, values: Any) -> Mapping[str, Any]:
    """An array of structs: each by its number, Simulink's signals and those of its data sets
    by their labels."""
    each = list(np.ravel(np.asarray(values, dtype=object)))
    if (rows := _one_a_sample(each)) is not None:
        return rows
    out: dict[str, object] = {}
    for k, value in enumerate(each, 1):
        if isinstance(value, Mapping):
            label = str(value.get("label") or value.get("Name") or "")
            out[label or f"{name}{k}"] = value.get("values", value)
    return out


def _one_a_sample(structs: Sequence[Any]) -> Mapping[str, Any] | None:
    """(N, k) by field, of as many structs as there are samples, all alike and of a few numbers
    each; None where they are something else."""
    if len(structs) <= FEW or not all(isinstance(one, Mapping) for one in structs):
        return None
    shapes = {tuple((k, np.shape(v)) for k, v in one.items()) for one in structs}
    if len(shapes) != 1 or any(len(shape) > 1 for _, shape in next(iter(shapes))):
        return None
    stacked = {name: np.array([one[name] for one in structs]) for name in structs[0]}
    return {name: v for name, v in stacked.items() if v.dtype.kind in "fiub"}


def damaged(path: Path, expected: str, error: Exception) -> UserError:
    said = (str(error).strip() or type(error).__name__).splitlines()[0][:120]
    return UserError(f"{path}: cannot be read ({said}); expected {expected}")
