"""Named columns from any kind of file, as samples of a robot at equal steps."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from pa10d.common.errors import UserError
from pa10d.measurement import timing_words
from pa10d.measurement.believable import EXPECTED, believable, refuse_vanishing
from pa10d.readers.part import Parts
from pa10d.readers.value_guess import guessed_by_value, one_block
from pa10d.store.channels import Array, Samples
from pa10d.store.column_choices import rules_of
from pa10d.store.column_mapping import Rule, Unit, of_strange_units, resolve, stamps_of
from pa10d.store.csv_header import Columns, Header
from pa10d.store.csv_import import (
    FEWEST,
    CsvRecording,
    begins_anew,
    of_others,
    unit_since_1970,
    with_clock,
    wraps_of,
)
from pa10d.store.equal_steps import equal_steps


@dataclass
class ForeignTable:
    """columns: name -> (N,); remarks: what the reader has to say; parts: where the file holds
    several recordings."""

    columns: Mapping[str, Array]
    remarks: list[str] = field(default_factory=list)
    parts: Parts | None = None


def recording_of(
    path: Path,
    table: ForeignTable,
    n: int,
    robot: str,
    constants: Sequence[float] | None,
    rules: Sequence[Rule],
    joints: Sequence[str] = (),
) -> CsvRecording:
    """See ``pa10d.store.csv_import.read_csv``; the same for columns that are in memory.

    joints: the robot's own names for them, by which columns may be called.
    """
    names = tuple(table.columns)
    resolved = resolve(rules, names, n, str(path))
    header = Header(str(path), names, resolved.fields, joints)
    try:
        columns = header.columns(n, constants is not None, robot)
    except UserError as found:
        error = UserError(with_clock(str(found), table.columns))
        if "c1" not in names:
            by_value = _by_value(table, n) if one_block(names) else ""
            if by_value:
                by_value = f"; by their values perhaps --map {by_value}"
            raise UserError("; ".join([f"{error}{by_value}", *table.remarks])) from error
        raise UserError(
            f"{path}:1: found numbers, expected a header time,q1,…,tau1,… above them, or "
            f"--map {_by_value(table, n)} ({len(names)} columns)"
        ) from error
    table.columns, others = _with_motion(table.columns, [names[k] for k in columns.of_the_motion()])
    columns.warnings += [of_others(str(path), others)] if others else []
    columns.warnings += of_strange_units(resolved, str(path))
    cells = _Cells(path, names, table.columns, resolved.units)
    t = stamps_of(cells.take(columns.time), resolved.units.get(names[columns.time], Unit()))
    if len(t) < FEWEST:
        raise UserError(f"{path}: found {len(t)} samples, expected at least {FEWEST}")
    distinct = 1 + int((np.diff(t) > 0).sum())
    if 1 < distinct < FEWEST:
        raise UserError(f"{path}: found {distinct} different stamps, expected at least {FEWEST}")
    back = np.flatnonzero(np.diff(t) < 0)
    if len(back):
        row = int(back[0]) + 1
        raise UserError(
            f"{path}: column {names[columns.time]}: sample {row + 1} is at {t[row]:.15g} s after "
            f"{t[row - 1]:.15g} s, expected stamps that rise"
            + begins_anew(t, row, names[columns.time], resolved.units.get(names[columns.time]))
        )
    if not t[-1] > t[0]:
        raise UserError(f"{path}: all samples have one stamp; expected a recording of a motion")
    columns.set_gappy_aside(str(path), cells.gaps)
    samples = _samples(cells, columns, constants)
    cells.forget()
    table.columns = {}  # an hour at 1 kHz is not to be held twice
    refuse_vanishing(str(path), samples.tau)
    wraps = wraps_of(samples, resolved)
    try:
        timing, samples = equal_steps(t, samples)
    except UserError as error:
        clock = "" if names[columns.time] in resolved.units else names[columns.time]
        raise UserError(f"{path}: {error}{unit_since_1970(t, clock)}") from error
    zero = -min(0, int(samples.stamps[0]))
    samples.stamps[:] += zero
    said = [f"{path}: {sentence}" for sentence in timing_words.told(timing)]
    remarks = [f"{path}: {remark}" for remark in table.remarks]
    called = {field: column for column, field in resolved.fields.items()}
    return CsvRecording(
        samples, zero, timing, [*remarks, *columns.warnings], said, called, resolved.said, wraps,
        table.parts.another if table.parts else "",
    )  # fmt: skip


def _with_motion(
    columns: Mapping[str, Array], motion: Sequence[str]
) -> tuple[Mapping[str, Array], int]:
    """Without the rows in which all of ``motion`` is nan, and how many those are."""
    there = [np.asarray(columns[name], dtype=np.float64) for name in motion]
    if len({len(values) for values in there}) != 1 or not np.isnan(there[0]).any():
        return columns, 0
    keep = ~np.logical_and.reduce([np.isnan(values) for values in there])
    return {name: np.asarray(v)[keep] for name, v in columns.items()}, int((~keep).sum())


def _by_value(table: ForeignTable, n: int) -> str:
    rules = rules_of(guessed_by_value(table.columns, n), n)
    if rules:
        return " ".join(map(shlex.quote, rules))
    return "c1=time c2=q1 …" if "c1" in table.columns else ""


class _Cells:
    def __init__(
        self,
        path: Path,
        names: Sequence[str],
        columns: Mapping[str, Array],
        units: Mapping[str, Unit],
    ) -> None:
        self._path, self._names, self._columns, self._units = path, names, columns, units

    def forget(self) -> None:
        """Let go of the columns."""
        self._columns = {}

    def gaps(self, column: int) -> int:
        """Cells of a column that are no finite number."""
        values = np.asarray(self._columns[self._names[column]], dtype=np.float64)
        return int((~np.isfinite(values)).sum())

    def take(self, column: int) -> Array:
        """One column in SI units, every value a number that can be believed."""
        name = self._names[column]
        values = self._units.get(name, Unit())(np.asarray(self._columns[name], dtype=np.float64))
        bad = np.flatnonzero(~believable(values))
        if len(bad):
            raise UserError(
                f"{self._path}: column {name}: sample {bad[0] + 1} is {values[bad[0]]}, "
                f"expected {EXPECTED}"
            )
        return values

    def block(self, columns: Sequence[int]) -> Array:
        """(N, n)."""
        return np.stack([self.take(column) for column in columns], axis=1)

    def extra(self, columns: Mapping[str, int]) -> dict[str, Array]:
        """Channels that are kept as they are."""
        return {
            name: np.array(self._columns[self._names[k]], dtype=np.float64)
            for name, k in columns.items()
        }


def _samples(cells: _Cells, columns: Columns, constants: Sequence[float] | None) -> Samples:
    torque = []
    for j, column in enumerate(columns.tau):
        if column is not None:
            torque.append(cells.take(column))
        else:
            amperes = (columns.current or [])[j]
            assert constants is not None
            assert amperes is not None
            torque.append(constants[j] * cells.take(amperes))
    current = [column for column in columns.current or [] if column is not None]
    return Samples(
        stamps=np.empty(0, np.int64),
        q=cells.block(columns.q),
        tau=np.stack(torque, axis=1),
        dq=None if columns.dq is None else cells.block(columns.dq),
        temperature=None if columns.temperature is None else cells.block(columns.temperature),
        current=cells.block(current) if len(current) == len(columns.q) else None,
        extra=cells.extra(columns.extra),
    )
