"""Reads a recording from CSV: time,q1..qn,tau1..taun and whatever else was written beside them.

Arrow parses; where it finds fault, the file is read again line by line to say where.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.measurement import timing_words
from pa10d.measurement.believable import EXPECTED, believable, refuse_vanishing
from pa10d.measurement.counters import Wrap, wrap_of
from pa10d.measurement.sampling import Timing
from pa10d.store.channels import Array, Samples
from pa10d.store.column_mapping import (
    UNITS,
    Resolved,
    Unit,
    of_strange_units,
    read_mapping,
    resolve,
    stamps_of,
)
from pa10d.store.csv_header import Columns, Header
from pa10d.store.csv_locate import (
    first_fault,
    is_comment,
    is_gzip,
    line_of_row,
    refuse_bombs,
    rows,
)
from pa10d.store.equal_steps import equal_steps

CLOCK_BITS = (8, 16, 32)  # of counters that are logged for stamps
CLOCK_ROUNDS = (1.0, 60.0, 3600.0, 86_400.0)  # s after which parts of a time of day begin anew
SINCE_1970 = (3e8, 4.2e9)  # s: from 1979 to 2103
FEWEST = 100  # samples; below that nothing can be filtered, let alone fitted


@dataclass(frozen=True)
class CsvRecording:
    """A file's samples at equal steps; its time 0 is the stamp ``time_zero_ns``."""

    samples: Samples
    time_zero_ns: int
    timing: Timing
    header_warnings: list[str]
    timing_warnings: list[str]
    called: Mapping[str, str] = field(default_factory=dict)  # field -> its column, if mapped
    said: Mapping[str, str] = field(default_factory=dict)  # column -> its unit, as it was given
    wraps: Mapping[str, Wrap] = field(default_factory=dict)  # field -> how it began anew, as logged
    another: str = ""  # how another recording of the same file is asked for


def read_csv(
    path: Path,
    n: int,
    robot: str,
    torque_constants: Sequence[float] | None = None,
    mapping: Sequence[str] = (),
    kept: Sequence[str] = (),
    joints: Sequence[str] = (),
) -> CsvRecording:
    """A recording of a robot with n joints; UserError names file, line and column.

    torque_constants: (n,) N·m per A, used for joints that have a motor current but no torque.
    mapping: ``COLUMN=FIELD`` options; kept: further ones, for whatever columns are there.
    joints: the robot's own names for its joints, by which columns may be called.
    """
    rules = read_mapping(mapping, kept)
    refuse_bombs(path)
    names = [name.strip() for name in _first_line(path)]
    given = resolve(rules, names, n, f"{path}:1")
    header = Header(f"{path}:1", names, given.fields, joints)
    try:
        columns = header.columns(n, torque_constants is not None, robot)
    except UserError as error:
        raise UserError(with_clock(str(error), _first_samples(path, names))) from error
    columns.units = {names.index(name): unit for name, unit in given.units.items()}
    table = _Table(path, columns)
    columns.warnings += [of_others(str(path), table.others)] if table.others else []
    columns.warnings += of_strange_units(given, f"{path}:1")
    columns.set_gappy_aside(str(path), table.gaps)
    warnings = list(columns.warnings)
    t = stamps_of(table.take(columns.time), columns.units.get(columns.time, Unit()))
    if len(t) < FEWEST:
        raise UserError(_too_few(path, len(t), "samples"))
    _refuse_backwards(path, t, names[columns.time], columns.units.get(columns.time), table.line)
    distinct = 1 + int((np.diff(t) > 0).sum())
    if distinct < FEWEST:
        raise UserError(_too_few(path, distinct, "different stamps"))
    samples = _samples(table, columns, t, torque_constants)
    if table.left_out:
        warnings.append(f"{path}: no numbers in {', '.join(table.left_out)}: left out")
    del table
    wraps = wraps_of(samples, given)
    clock = names[columns.time] if columns.time not in columns.units else ""
    refuse_vanishing(str(path), samples.tau)
    timing, samples = _equal_steps(path, t, samples, clock)
    said = [f"{path}: {sentence}" for sentence in timing_words.told(timing)]
    zero = -min(0, int(samples.stamps[0]))
    samples.stamps[:] += zero
    called = {name: column for column, name in given.fields.items()}
    return CsvRecording(samples, zero, timing, warnings, said, called, given.said, wraps)


def read_columns(path: Path) -> tuple[dict[str, Array], list[str]]:
    """Every column that holds numbers, and a sentence on those that do not; errors as ``read_csv``
    has them."""
    refuse_bombs(path)
    names = Header(f"{path}:1", _first_line(path), {}).names
    header = Columns(names, -1, [], [], extra={name: k for k, name in enumerate(names)})
    table = _Table(path, header)
    columns = table.extra()
    if table.left_out:
        return columns, [f"no numbers in {', '.join(table.left_out)}: left out"]
    return columns, []


def wraps_of(samples: Samples, given: Resolved) -> dict[str, Wrap]:
    """Field -> how its numbers begin anew, where they do. given: how the file was read."""
    blocks = {"q": samples.q, "tau": samples.tau, "dq": samples.dq}
    columns = {field: column for column, field in given.fields.items()}
    found = {}
    for kind, block in blocks.items():
        for j, values in enumerate(() if block is None else block.T, 1):
            unit = given.units.get(columns.get(f"{kind}{j}", ""), Unit())
            factor = unit.factor if unit.word is None else 1.0  # its sign was put back
            wrap = wrap_of(values, factor, position=kind == "q")
            if wrap is not None:
                found[f"{kind}{j}"] = wrap
    return found


def _equal_steps(path: Path, t: Array, samples: Samples, clock: str) -> tuple[Timing, Samples]:
    try:
        return equal_steps(t, samples)
    except UserError as error:
        raise UserError(f"{path}: column time: {error}{unit_since_1970(t, clock)}") from error


def unit_since_1970(t: Array, clock: str) -> str:
    """A ready mapping for stamps (N,) of the column ``clock`` that count from 1970 in less than
    seconds; nothing where they do not, or where a unit was given (clock: '')."""
    for unit in ("ms", "us", "ns") if clock else ():
        if SINCE_1970[0] < t[-1] * UNITS[unit] < SINCE_1970[1]:
            return f"; perhaps --map '{clock}[{unit}]=time'"
    return ""


def with_clock(said: str, columns: Mapping[str, Array]) -> str:
    """A refusal whose ready mapping knows what the stamps count, as far as they count from 1970.
    columns: the file's, or as much of them as is known."""
    for name, values in columns.items():
        for called in (f" --map {name}=time", f" --map '{name}=time'"):
            if called in said and len(values) and (told := unit_since_1970(values, name)):
                return said.replace(called, told.removeprefix("; perhaps"))
    return said


def of_others(where: str, rows: int) -> str:
    """What is said of rows that hold nothing of the robot."""
    return f"{where}: {rows} rows without any position or torque: left out"


class _Table:
    """The parsed file; columns are handed out once, so that memory is freed as they go."""

    def __init__(self, path: Path, columns: Columns) -> None:
        self.path, self._columns = path, columns
        self.left_out: list[str] = []
        self._table = _parse(path, columns)
        self._kept: NDArray[np.intp] | None = None  # numbers of the rows that are left
        self.others = self._leave_out(columns.of_the_motion())

    def _leave_out(self, motion: Sequence[int]) -> int:
        """Rows in which none of these columns has a value; how many there were."""
        if not motion or not self._table[f"c{motion[0]}"].null_count:
            return 0
        import pyarrow as pa

        nulls = [self._table[f"c{column}"].is_null().to_numpy() for column in motion]
        empty = np.logical_and.reduce(nulls)
        if not empty.any():
            return 0
        self._kept = np.flatnonzero(~empty)
        self._table = self._table.filter(pa.array(~empty))
        return int(empty.sum())

    def line(self, row: int) -> int:
        """The line of the file in which a row stands."""
        return line_of_row(self.path, row if self._kept is None else int(self._kept[row]))

    def gaps(self, column: int) -> int:
        """Cells that are empty or no finite number."""
        return int((~np.isfinite(self._table[f"c{column}"].to_numpy())).sum())

    def take(self, column: int) -> Array:
        """A column in which every cell is a number that can be believed."""
        values = self._table[f"c{column}"]
        array: Array = values.to_numpy().astype(np.float64, copy=False)
        unit = self._columns.units.get(column)
        array = array if unit is None else unit(array)
        if values.null_count or not believable(array).all():
            raise UserError(_fault(self.path, self._columns, f"a cell that is not {EXPECTED}"))
        return array

    def block(self, columns: Sequence[int]) -> Array:
        """(N, n), one column per joint."""
        out = np.empty((len(self._table), len(columns)))
        for j, column in enumerate(columns):
            out[:, j] = self.take(column)
        return out

    def extra(self) -> dict[str, Array]:
        """The columns that the recording does not need, as far as they hold numbers."""
        import pyarrow as pa

        kept = {}
        for name, column in self._columns.extra.items():
            values = self._table[f"c{column}"]
            kind = values.type
            if pa.types.is_boolean(kind) or pa.types.is_integer(kind) or pa.types.is_floating(kind):
                kept[name] = values.cast(pa.float64()).to_numpy().astype(np.float64, copy=False)
            else:
                self.left_out.append(name)
        return kept


def _parse(path: Path, columns: Columns) -> Any:
    """A file is asked for remarks between its rows where it cannot be read without."""
    import pyarrow as pa

    try:
        try:
            return _table_of(path, columns, remarks=False)
        except pa.ArrowInvalid:
            return _table_of(path, columns, remarks=True)
    except (pa.ArrowInvalid, OSError) as error:
        raise UserError(_fault(path, columns, str(error).splitlines()[0])) from error


def _table_of(path: Path, columns: Columns, remarks: bool) -> Any:
    import pyarrow as pa
    from pyarrow import csv

    required = columns.required()
    wanted = sorted({*required, *columns.extra.values()})
    names = [f"c{k}" for k in range(len(columns.names))]
    stream = pa.input_stream(str(path), compression="gzip" if is_gzip(path) else None)
    if remarks:  # Arrow decodes a row before it asks what to do with it: any byte is a letter so
        stream = pa.transcoding_input_stream(stream, "latin-1", "utf-8")
    with stream:
        return csv.read_csv(
            stream,
            csv.ReadOptions(column_names=names, skip_rows=1, block_size=1 << 22),
            csv.ParseOptions(invalid_row_handler=_pass_over_comments if remarks else None),
            csv.ConvertOptions(
                column_types={f"c{k}": pa.float64() for k in required},
                include_columns=[f"c{k}" for k in wanted],
                check_utf8=False,
            ),
        )


def _pass_over_comments(row: Any) -> str:
    return "skip" if is_comment(row.text) else "error"


def _fault(path: Path, columns: Columns, otherwise: str) -> str:
    try:
        found = first_fault(path, columns.names, columns.required())
    except UserError as error:
        return str(error)
    if found is None and not line_of_row(path, 0):
        return _too_few(path, 0, "samples")
    return found or f"{path}: {otherwise}; expected comma-separated numbers"


def _too_few(path: Path, count: int, what: str) -> str:
    return f"{path}: found {count} {what}, expected at least {FEWEST}"


def _first_line(path: Path) -> list[str]:
    try:
        first = next(rows(path), None)
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}; expected a CSV file") from error
    if first is None:
        raise UserError(f"{path}: an empty file; expected a header time,q1,…,tau1,… and samples")
    if first[0] != 1:
        raise UserError(f"{path}:1: an empty line; expected a header time,q1,…,tau1,…")
    return first[1]


def _first_samples(path: Path, names: Sequence[str]) -> dict[str, Array]:
    """The first row's numbers, each a column of one."""
    _, cells = next(islice(rows(path), 1, None), (0, []))
    found = {}
    for name, cell in zip(names, cells, strict=False):
        with suppress(ValueError):
            found[name] = np.array([float(cell)])
    return found


def begins_anew(t: Array, row: int, name: str, unit: Unit | None) -> str:
    """A ready mapping for stamps (N,) s that go back at ``row`` as a counter or a clock does that
    begins anew; nothing for others. name: their column; unit: as it was read."""
    factor = 1.0 if unit is None else unit.factor
    back = (t[row - 1] - t[row] + max(float(np.median(np.diff(t))), 0.0)) / factor
    for period in (*(2.0**bits for bits in CLOCK_BITS), *(s / factor for s in CLOCK_ROUNDS)):
        if abs(back - period) < 0.01 * period:
            times = "" if factor == 1 else f"*{factor:.10g}"
            return f"; they begin anew: perhaps --map '{name}[wrap{period:.10g}{times}]=time'"
    return ""


def _refuse_backwards(
    path: Path, t: Array, name: str, unit: Unit | None, line: Callable[[int], int]
) -> None:
    back = np.flatnonzero(np.diff(t) < 0)
    if len(back):
        row = int(back[0]) + 1
        raise UserError(
            f"{path}:{line(row)}: column time: found {t[row]:.15g} after "
            f"{t[row - 1]:.15g}, expected stamps that rise{begins_anew(t, row, name, unit)}"
        )


def _samples(
    table: _Table, columns: Columns, t: Array, constants: Sequence[float] | None
) -> Samples:
    tau = np.empty((len(t), len(columns.q)))
    for j, column in enumerate(columns.tau):
        if column is not None:
            tau[:, j] = table.take(column)
        elif constants is not None and (amperes := (columns.current or [])[j]) is not None:
            tau[:, j] = constants[j] * table.take(amperes)
    current = [column for column in columns.current or [] if column is not None]
    return Samples(
        stamps=np.empty(0, np.int64),
        q=table.block(columns.q),
        tau=tau,
        dq=None if columns.dq is None else table.block(columns.dq),
        temperature=None if columns.temperature is None else table.block(columns.temperature),
        current=table.block(current) if len(current) == len(columns.q) else None,
        extra=table.extra(),
    )
