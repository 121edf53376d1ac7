"""The header of a CSV recording: which column is what."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from pa10d.common.errors import UserError
from pa10d.store.column_choices import rules_of
from pa10d.store.column_guess import guessed
from pa10d.store.column_mapping import FIELD, Unit

_ALIASES = {"t", "stamp", "timestamp", "time_s", "time[s]", "time [s]", "seconds", "sec"}


@dataclass
class Columns:
    """Column numbers from 0. A list has one entry per joint."""

    names: tuple[str, ...]
    time: int  # -1: not known yet
    q: list[int]
    tau: list[int | None]  # None: from the motor current
    dq: list[int] | None = None
    current: list[int | None] | None = None  # None within: not measured, and not needed
    temperature: list[int] | None = None
    extra: dict[str, int] = field(default_factory=dict)
    units: dict[int, Unit] = field(default_factory=dict)  # of columns that are not in SI
    warnings: list[str] = field(default_factory=list)

    def set_gappy_aside(self, where: str, gaps: Callable[[int], int]) -> None:
        """Velocity, temperature and spare currents with cells that are no number become extra
        channels: a recording is whole without them. gaps: how many such cells a column has."""
        spare = {"velocity": "dq", "temperature": "temperature"}
        if None not in self.tau:
            spare["current"] = "current"
        for quantity, block in spare.items():
            held = [k for k in getattr(self, block) or [] if k is not None]
            counts = {k: count for k in held if (count := gaps(k))}
            if not counts:
                continue
            setattr(self, block, None)
            self.extra |= {self.names[k]: k for k in held}
            self.warnings.append(
                f"{where}: {sum(counts.values())} cells of "
                f"{', '.join(self.names[k] for k in counts)} are no finite numbers: all columns of "
                f"the {quantity} are kept as extra channels only"
            )

    def of_the_motion(self) -> list[int]:
        """Positions, torques and the currents that stand for them: a row in which all of these are
        empty is of another signal, whose stamps stand in the same table."""
        currents = self.current or [None] * len(self.tau)
        pairs = zip(self.tau, currents, strict=True)
        torques = (current if tau is None else tau for tau, current in pairs)
        return [*self.q, *(column for column in torques if column is not None)]

    def required(self) -> list[int]:
        """Columns in which every cell must be a finite number."""
        lists: list[Sequence[int | None]] = [
            self.q,
            self.tau,
            self.dq or [],
            self.temperature or [],
            self.current or [],
        ]
        time = [self.time] if self.time >= 0 else []
        return [*time, *(k for some in lists for k in some if k is not None)]


class Header:
    """The names of a file's first line, with the user's mapping applied."""

    def __init__(
        self,
        where: str,
        names: Sequence[str],
        mapping: dict[str, str],
        joints: Sequence[str] = (),
    ) -> None:
        """``where``: file and line, as messages begin; joints: the robot's own names for them."""
        self.where, self._joints, self._mapping = where, joints, mapping
        self.names = tuple(name.strip() for name in names)
        self._check_it_is_one()
        self._place: dict[str, int] = {}
        for k, name in enumerate(self.names):
            meaning = mapping.get(name, name)
            own = FIELD.fullmatch(name)
            if own and name not in mapping and f"{own[2]}0" in mapping:
                meaning = f"{name} (file)"  # counted from 0, of one joint more than the robot has
            if meaning in self._place and meaning:
                first = self._place[meaning] + 1
                raise UserError(
                    f"{where}: columns {first} and {k + 1} are both {meaning!r}; expected one"
                )
            self._place[meaning] = k

    def columns(self, n: int, constants: bool, robot: str) -> Columns:
        """The columns for a robot with n joints; ``constants``: currents can become torques."""
        joints = range(1, n + 1)
        place = self._place
        self._refuse_counts_from_zero(n)
        missing = [name for name in ("time", *(f"q{j}" for j in joints)) if name not in place]
        tau = [place.get(f"tau{j}") for j in joints]
        for j, column in zip(joints, tau, strict=True):
            if column is None and not (constants and f"i{j}" in place):
                missing.append(f"tau{j}")
        if missing:
            raise UserError(self._missing(missing, n, robot))
        columns = Columns(
            self.names, place["time"], [place[f"q{j}"] for j in joints], tau,
            dq=self._of_every_joint("dq", n), temperature=self._of_every_joint("temp", n),
        )  # fmt: skip
        current = [place.get(f"i{j}") for j in joints]
        if None in tau or None not in current:
            columns.current = current
        self._keep_the_rest(columns, n, robot)
        return columns

    def _of_every_joint(self, prefix: str, n: int) -> list[int] | None:
        found = [
            self._place[f"{prefix}{j}"] for j in range(1, n + 1) if f"{prefix}{j}" in self._place
        ]
        return found if len(found) == n else None

    def _refuse_counts_from_zero(self, n: int) -> None:
        """q0 … qn are of one joint more than the robot has: which of them are its own?"""
        there = all(f"q{j}" in self.names for j in range(n + 1))
        if there and not any(field.startswith("q") for field in self._mapping.values()):
            raise UserError(
                f"{self.where}: q0 … q{n} are {n + 1} joints counted from 0, the robot has {n}; "
                "expected --map 'q{n-1}=q' 'tau{n-1}=tau', or 'q{n}=q' 'tau{n}=tau'"
            )

    def _keep_the_rest(self, columns: Columns, n: int, robot: str) -> None:
        used = {*columns.required()}
        for name, k in self._place.items():
            if k in used:
                continue
            if not name:
                columns.warnings.append(f"{self.where}: column {k + 1} has no name: left out")
                continue
            match = FIELD.fullmatch(name)
            if match and match[3] and int(match[3]) > n:
                all_of = f"the {n} joint{'' if n == 1 else 's'} of {robot}"
                columns.warnings.append(
                    f"{self.where}: {name} is beyond {all_of}: kept as an extra channel"
                )
            elif match and match[2]:
                columns.warnings.append(
                    f"{self.where}: {name} without {match[2]} of every joint: "
                    "kept as an extra channel"
                )
            columns.extra[name] = k

    def _check_it_is_one(self) -> None:
        if len(self.names) == 1:
            for sign, called in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars")):
                if sign in self.names[0]:
                    raise UserError(
                        f"{self.where}: columns are parted by {called}; expected commas"
                    )
        if self.names and all(_is_number(name) for name in self.names):
            raise UserError(
                f"{self.where}: found numbers, expected a header time,q1,…,tau1,… above them"
            )

    def _missing(self, missing: list[str], n: int, robot: str) -> str:
        have = {name.lower() for name in self.names}
        wanted = (
            f"time, q1..q{n}, tau1..tau{n} for the {n} joints of {robot}"
            if n > 1
            else f"time, q1, tau1 for the joint of {robot}"
        )
        hint = ""
        lowered = {name.lower(): name for name in self.names}
        for name in missing:
            near = lowered.get(name) or (
                next((lowered[a] for a in _ALIASES if a in lowered), "") if name == "time" else ""
            )
            if near:
                hint = f"; perhaps --map {near}={name}"
                break
        if not hint and missing[0].startswith("tau") and f"i{missing[0][3:]}" in have:
            hint = "; motor currents need 'torque_constants' in the profile"
        chosen = guessed(self.names, n, self._joints)
        options = rules_of(chosen, n)
        if len(options) > 1 or (options and not hint):
            hint = "; perhaps --map " + " ".join(map(shlex.quote, options))
        fields = {choice.field for choice in chosen}
        if "i1" in fields and "tau1" in missing and "tau1" not in fields:
            hint += "; motor currents need 'torque_constants' in the profile"
        open_ = [] if "i1" in fields else [f for f in ("q1", "tau1") if f in missing]
        if "--map" in hint and (unknown := [f for f in open_ if f not in fields]):
            asked_for = " ".join(f"COLUMN={f if n == 1 else f[:-1]}" for f in unknown)
            hint += f" {asked_for}, with what the columns are called" + ", {n} for the joint" * (
                n > 1
            )
        some = ", ".join(missing[:8]) + (" …" if len(missing) > 8 else "")
        if "tau1" in missing and "tau1" not in fields and "i1" not in fields:
            asked = guessed(self.names, n, self._joints, demanded=True)
            rules = rules_of([choice for choice in asked if choice.field.startswith("tau")], n)
            if rules:
                line = " ".join(map(shlex.quote, rules))
                hint += f"; torques that were asked for, not measured, are there: --map {line}"
        return f"{self.where}: no column {some}; found {self._found()}; expected {wanted}{hint}"

    def _found(self) -> str:
        text = ", ".join(name for name in self.names if name) or "no names in its header"
        return text if len(text) <= 120 else text[:117] + "..."


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
