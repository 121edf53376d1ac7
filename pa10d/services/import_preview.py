"""A file before it is imported: its columns, what they seem to be, and what to know of them.

What is shown is what an import with the same mapping would make of it: the rules kept in the
profile stand behind those that somebody chose.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pa10d.checks import CheckFinding, unit_of_stamps
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject, plain
from pa10d.dynamics.robot import Robot
from pa10d.profile import Profile
from pa10d.readers import (
    WHOLE,
    ForeignTable,
    Part,
    Parts,
    Undecided,
    guessed_by_value,
    one_block,
    read_table,
    recording_of,
)
from pa10d.services.mending import mends
from pa10d.services.runs import findings_of, in_own_words
from pa10d.store.column_choices import Choice, composed, field_of, rules_of
from pa10d.store.column_guess import guessed, unit_in
from pa10d.store.column_mapping import Resolved, Unit, read_mapping, resolve

Array = NDArray[np.float64]
Progress = Callable[[float, str], None]

ROWS = 5  # of each column that are shown
BUCKETS = 60  # of a small curve, two points each
MOST = 200  # columns that are shown
REMEMBERED = 300_000_000  # bytes of a file's columns that are kept for the next question
BY_RANGE = ("degrees", "motor_side", "time_unit", "wrapped")  # what sizes alone tell
ROUNDS = 3  # a guess by sizes may uncover another


@dataclass(frozen=True)
class Column:
    """field: what it is read as, '' for a further channel; unit: what its numbers are in, '' for
    SI; first: as the file has them; low, high, curve: in SI where it has a field."""

    name: str
    field: str
    unit: str
    first: list[float]
    low: float
    high: float
    curve: list[float]


@dataclass(frozen=True)
class Mendable:
    """What to know of the file before fitting; mends: choices that would mend it."""

    finding: CheckFinding
    mends: list[Choice]

    def document(self) -> JsonObject:
        """As JSON."""
        return {**self.finding.document(), "mends": [asdict(one) for one in self.mends]}


@dataclass(frozen=True)
class ImportPreview:
    """rules: the mapping, as ``--map`` takes it; problem: why an import would be refused; parts:
    what the file holds several of; part: what was asked for."""

    file: str
    joints: tuple[str, ...]
    samples: int
    columns: list[Column]
    left_out: int
    rules: list[str]
    problem: str = ""
    remarks: list[str] = field(default_factory=list)
    findings: list[Mendable] = field(default_factory=list)
    duration: float | None = None
    rate: float | None = None
    parts: Parts | None = None
    part: Part = WHOLE

    @property
    def line(self) -> str:
        """Ready to be typed; empty where the file needs none."""
        asked = [] if self.part.topic is None else ["--topic", self.part.topic]
        asked += [] if self.part.episode is None else ["--episode", str(self.part.episode)]
        asked += ["--map", *self.rules] if self.rules else []
        return shlex.join(asked)

    def document(self) -> JsonObject:
        """As JSON."""
        findings = [one.document() for one in self.findings]
        return dict(plain({**asdict(self), "findings": findings, "line": self.line}))


def preview_recording(
    file: Path,
    profile: Profile,
    robot: Robot,
    choices: Sequence[Choice] | None = None,
    *,
    mapping: Sequence[str] = (),
    thorough: bool = True,
    progress: Progress = lambda share, words: None,
    part: Part = WHOLE,
) -> ImportPreview:
    """choices: what somebody takes the columns for; None: guess, from names, units and ranges,
    whatever ``mapping`` (``COLUMN=FIELD`` options) does not say.
    thorough: also what needs a fit (delay, signs, size of the torque). part: of a file that holds
    several recordings. UserError where the file cannot be read at all."""
    try:
        table = _table(file, profile, robot, lambda s: progress(0.8 * s, "reading"), part)
    except Undecided as error:
        problem = f"it holds {len(error.parts.options)} recordings: choose the {error.parts.kind}"
        return ImportPreview(
            file.name, robot.joint_names, 0, [], 0, [], problem, parts=error.parts, part=part
        )
    look = _Look(file, table, part, profile, robot)
    if choices is None:
        choices = look.guess(mapping)
    progress(0.9, "checking")
    return look.preview(choices, thorough)


class _Look:
    def __init__(
        self,
        file: Path,
        table: ForeignTable,
        part: Part,
        profile: Profile,
        robot: Robot,
    ) -> None:
        self._file, self._columns, self._remarks = file, table.columns, [*table.remarks]
        self._parts, self._part = table.parts, part
        self._profile, self._robot = profile, robot
        self._kept = profile.map or []

    def guess(self, mapping: Sequence[str]) -> list[Choice]:
        """What is given, what the profile keeps, what names say, and what sizes say of the rest."""
        names, n = list(self._columns), self._robot.n
        kept = resolve(read_mapping(mapping, self._kept), names, n, str(self._file))
        choices = [Choice(c, f, kept.said.get(c, "")) for c, f in kept.fields.items()]
        taken = {*kept.fields, *kept.fields.values()}
        by_name = guessed(names, n, self._robot.joint_names)
        if not by_name and not choices and one_block(names):  # a file without a header
            by_name = guessed_by_value(self._columns, n)
        choices += [c for c in by_name if c.column not in taken and c.field not in taken]
        choices = [self._with_unit_of_time(choice) for choice in choices]
        for _ in range(ROUNDS):
            seen = self.preview(choices, thorough=False)
            new: dict[str, Choice] = {}
            for one in seen.findings:
                for choice in one.mends if one.finding.code in BY_RANGE else ():
                    new.setdefault(choice.column, choice)
                if one.finding.code == "angle_unit" and one.finding.severity == "error":
                    new = self._as_degrees(choices, one.finding) | new
            if seen.problem or not new:
                break
            choices = [new.pop(choice.column, choice) for choice in choices] + list(new.values())
        return choices

    def _as_degrees(self, choices: Sequence[Choice], finding: CheckFinding) -> dict[str, Choice]:
        """What nothing tells is taken for what is most usual, and that is said; behind gears that
        a profile knows it is not."""
        if self._profile.drives:
            return {}
        self._remarks.append(f"{finding.sentence}; taken for degrees here; {finding.advice}")
        turning = {f"q{j + 1}" for j in np.flatnonzero(~self._robot.prismatic)}
        positions = [choice for choice in choices if choice.field in turning]
        return {c.column: replace(c, unit=composed(c.unit, "deg")) for c in positions}

    def _with_unit_of_time(self, choice: Choice) -> Choice:
        """Stamps that are no seconds are refused before anything can be checked."""
        if choice.field != "time" or choice.unit or unit_in(choice.column):
            return choice
        steps = np.diff(self._columns[choice.column])
        middle = float(np.median(steps)) if len(steps) else 0.0
        return replace(choice, unit=unit_of_stamps(1.0 / middle) or "") if middle > 0 else choice

    def preview(self, choices: Sequence[Choice], thorough: bool) -> ImportPreview:
        """The whole answer for one mapping."""
        robot, path = self._robot, self._file
        rules = rules_of(choices, robot.n)
        names = list(self._columns)
        try:
            mapping = read_mapping(rules, self._kept)
            resolved = resolve(mapping, names, robot.n, path.name)
        except UserError as error:
            return self._made(Resolved({}, {}), rules, str(error))
        try:
            table = ForeignTable(dict(self._columns), list(self._remarks))
            constants = self._profile.torque_constants
            names_of_joints = robot.joint_names
            found = recording_of(
                path, table, robot.n, robot.name, constants, mapping, names_of_joints
            )
        except UserError as error:
            return self._made(resolved, rules, str(error))
        findings = findings_of(found, path.name, robot, self._profile, delay=thorough)
        shown = [
            Mendable(
                in_own_words(finding, found, robot.n),
                mends(finding, found.called, found.said, robot.n),
            )
            for finding in findings
        ]
        seconds = float(found.timing.grid[-1] - found.timing.grid[0])
        made = self._made(resolved, rules, "")
        return replace(
            made,
            remarks=[_without(path, said) for said in found.header_warnings],
            findings=shown,
            duration=seconds,
            rate=found.timing.rate,
        )

    def _made(self, resolved: Resolved, rules: list[str], problem: str) -> ImportPreview:
        n, names = self._robot.n, list(self._columns)
        order = {name: k for k, name in enumerate(names)}
        first = [name for name in names if field_of(name, resolved.fields, n)]
        shown = [*first, *(name for name in names if name not in set(first))][:MOST]
        columns = [
            _column(name, self._columns[name], field_of(name, resolved.fields, n), resolved)
            for name in sorted(shown, key=order.__getitem__)
        ]
        return ImportPreview(
            file=self._file.name,
            joints=self._robot.joint_names,
            samples=len(next(iter(self._columns.values()), [])),
            columns=columns,
            left_out=len(names) - len(shown),
            rules=rules,
            problem=_without(self._file, problem),
            remarks=[*self._remarks],
            parts=self._parts,
            part=self._part,
        )


def _column(name: str, values: Array, meant: str | None, resolved: Resolved) -> Column:
    unit = resolved.units.get(name, Unit()) if meant else Unit()
    seen = unit(values)
    finite = seen[np.isfinite(seen)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (np.nan, np.nan)
    said = resolved.said.get(name, "") if meant else ""
    first = [float(v) for v in values[:ROWS]]
    return Column(name, meant or "", said, first, low, high, small_curve(seen))


def small_curve(values: Array) -> list[float]:
    """(N,) as a line of at most 2·BUCKETS points that touches every extreme; nan for holes."""
    if len(values) <= 2 * BUCKETS:
        return [_short(v) for v in values]
    edges = np.linspace(0, len(values), BUCKETS + 1).astype(int)[:-1]
    low = np.fmin.reduceat(values, edges)
    high = np.fmax.reduceat(values, edges)
    rising = values[edges] <= values[np.append(edges[1:], len(values)) - 1]
    pairs = np.where(rising[:, None], np.stack([low, high], 1), np.stack([high, low], 1))
    return [_short(v) for v in pairs.reshape(-1)]


def _short(value: float) -> float:
    """As exact as a small curve can be drawn."""
    return float(f"{value:.4g}")


def _without(file: Path, text: str) -> str:
    """Where the file lies for a moment is nobody's business."""
    return text.replace(f"{file.parent}/", "")


def _table(
    file: Path, profile: Profile, robot: Robot, progress: Callable[[float], None], part: Part
) -> ForeignTable:
    """The file's columns and what its reader said; the last small one's are remembered, because a
    mapping is corrected step by step."""
    if not file.is_file():
        return read_table(file, profile, robot, progress, part)
    known = file.stat()
    version = (str(file), known.st_mtime_ns, known.st_size, part)
    if version in _remembered:
        return _remembered[version]
    found = read_table(file, profile, robot, progress, part)
    _remembered.clear()
    if sum(values.nbytes for values in found.columns.values()) < REMEMBERED:
        _remembered[version] = found
    return found


_remembered: dict[tuple[str, int, int, Part], ForeignTable] = {}
