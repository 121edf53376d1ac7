"""Rows of topics as columns of one time: each joint by its name, senders joined while all speak."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.readers.bag_clock import Stamps, begin_of, clock_of, refuse_two_courses
from pa10d.readers.bag_rows import BagRows, BagTopic
from pa10d.readers.table import ForeignTable
from pa10d.store.channels import Array

Series = tuple[Stamps, Array]
"""Stamps in ns that never fall, and values, none of them nan."""

FIELDS = {"position": "q", "velocity": "dq", "effort": "tau"}
NEEDED = (".position", ".effort")
HOLE = 5.0  # usual steps: what is longer was not measured
SLOW = 3.0  # times the usual step of the others: most of its samples are made up
SELDOM = 1.5  # usual steps between what comes more seldom; less is lost messages
FEWEST = 100  # samples of a recording
SECOND = 1_000_000_000  # ns


def columns_of(path: Path, topics: Mapping[str, BagTopic], joints: Sequence[str]) -> ForeignTable:
    """The robot's joints as q1 …, all else by its own name; topics: each by its name, no joint on
    two of them."""
    try:
        return _Joined(topics, joints).table()
    except UserError as error:
        raise UserError(f"{path}: {error}") from error


class _Joined:
    def __init__(self, topics: Mapping[str, BagTopic], joints: Sequence[str]) -> None:
        self._name = ", ".join(topics)
        self._blocks = [block for topic in topics.values() for block in topic.blocks]
        self._received, why = clock_of(self._blocks)
        self._remarks = [why] if why else []
        self._remarks += [
            f"{count} messages have not as many values of {kind} as names: these are left out"
            for topic in topics.values()
            for kind, count in topic.uneven.items()
        ]
        self._sorted: dict[int, tuple[Stamps, NDArray[np.int64] | None]] = {}
        self._there = list(dict.fromkeys(n for block in self._blocks for n in block.names))
        self._meant = self._fields(joints)

    def table(self) -> ForeignTable:
        found = {name: self._series(name) for name in self._there}
        series = {name: one for name, one in found.items() if len(one[0])}
        needed = [name for name in self._meant if name in series and name.endswith(NEEDED)]
        if not needed:
            largest = max(self._blocks, key=lambda block: len(block.stamps))
            needed = [name for name in largest.names if name in series]
        if not needed:
            raise UserError(f"{self._name}: no number in its messages; expected a recorded motion")
        lead = self._lead({name: series[name][0] for name in needed})
        keep = self._kept(lead, {name: series[name] for name in needed})
        stamps = lead if keep.all() else lead[keep]
        if not len(stamps):
            raise UserError(f"{self._name}: its senders never speak together; expected one motion")
        zero = int(stamps[0]) // SECOND * SECOND
        t = np.asarray((stamps - zero) * 1e-9, dtype=np.float64)
        out: dict[str, Array] = {"time": t}
        for name, one in series.items():
            column = self._meant.get(name, name)
            out[column] = self._at(stamps, lead, keep, one, name in needed)
            if column.startswith("q") and name in self._meant:
                refuse_two_courses(t, out[column])
        self._leave_out_speeds(out)
        return ForeignTable(out, self._remarks)

    def _lead(self, stamps: dict[str, Stamps]) -> Stamps:
        """The stamps that the others are taken at: the most; or those of what comes more seldom,
        where everything else was measured at each of them as well and nothing is made up."""
        most, least = (pick(stamps.values(), key=len) for pick in (max, min))
        seldom = len(least) >= FEWEST and _step(least) > SELDOM * _step(most)
        if not seldom or not all(np.isin(least, other).all() for other in stamps.values()):
            return most
        name = next(name for name, one in stamps.items() if one is least)
        self._remarks.append(
            f"{name} comes with {len(least)} of {len(most)} messages: these are taken"
        )
        return least

    def _fields(self, joints: Sequence[str]) -> dict[str, str]:
        """Name of a column -> its field, for the robot's joints."""
        have = {name.rpartition(".")[0] for name in self._there}
        prefixes = [] if have & set(joints) else _prefixes(have, joints)
        if len(prefixes) > 1:
            line = " ".join(
                f"'{prefixes[0]}{joint}.{kind}={field}{j}'"
                for kind, field in (("position", "q"), ("effort", "tau"))
                for j, joint in enumerate(joints, 1)
            )
            self._remarks.append(f"joints of several robots, {', '.join(prefixes)}: --map {line}")
        known = [joint for joint in joints if joint in have]
        if known and len(known) < len(joints):
            missing = ", ".join(joint for joint in joints if joint not in known)
            raise UserError(
                f"{self._name} has no joint {missing}; found {', '.join(sorted(have))}; expected "
                "the names of the robot's URDF, --map 'NAME.position=q1' …, or a profile whose "
                "'joints' are those that were recorded"
            )
        return {
            f"{joint}.{kind}": f"{field}{joints.index(joint) + 1}"
            for joint in known
            for kind, field in FIELDS.items()
        }

    def _series(self, name: str) -> Series:
        """All that was said of one quantity; views where one kind of message says it."""
        parts = [self._part(b, b.names.index(name)) for b in self._blocks if name in b.names]
        if len(parts) == 1:
            return parts[0]
        stamps = np.concatenate([part[0] for part in parts])
        values = np.concatenate([part[1] for part in parts])
        order = np.argsort(stamps, kind="stable")
        return stamps[order], values[order]

    def _part(self, block: BagRows, k: int) -> Series:
        if id(block) not in self._sorted:
            stamps = block.times(self._received)
            order = None if (np.diff(stamps) >= 0).all() else np.argsort(stamps, kind="stable")
            self._sorted[id(block)] = (stamps if order is None else stamps[order], order)
        stamps, order = self._sorted[id(block)]
        values = block.table()[:, k]
        values = values if order is None else values[order]
        holes = np.isnan(values)
        return (stamps[~holes], values[~holes]) if holes.any() else (stamps, values)

    def _kept(self, lead: Stamps, needed: dict[str, Series]) -> NDArray[np.bool_]:
        """Which of the lead's stamps all that is needed was measured at."""
        keep = np.ones(len(lead), bool)
        first = begin_of(lead)
        if first:
            keep[:first] = False
            self._remarks.append(
                f"{first} messages of {(lead[first] - lead[0]) * 1e-9:.0f} s before: left out"
            )
        usual = _step(lead)
        between: list[str] = []
        for name, (stamps, _) in needed.items():
            if stamps is lead or np.isin(lead, stamps).all():
                continue
            between.append(name)
            own = max(_step(stamps), usual)
            if own > SLOW * usual:
                self._remarks.append(
                    f"{name} comes at {SECOND / own:.3g} Hz, others at {SECOND / usual:.3g} Hz: "
                    "joined by straight lines"
                )
            seen = (lead > stamps[0] - 0.5 * usual) & (lead < stamps[-1] + 0.5 * usual)
            seen &= ~_within_holes(lead, stamps, HOLE * own)
            lost = int((keep & ~seen).sum())
            if lost:
                self._remarks.append(
                    f"{name} was not measured all the time: {lost} of {len(lead)} samples are "
                    "left out"
                )
            keep &= seen
        if between:
            clock = next(name for name, (stamps, _) in needed.items() if stamps is lead)
            self._remarks.append(
                f"{_joints(between)}: other stamps than {_joints([clock])}; taken at those of the "
                "latter, by straight lines"
            )
        return keep

    def _at(
        self, t: Stamps, lead: Stamps, keep: NDArray[np.bool_], one: Series, needed: bool
    ) -> Array:
        """Values at the stamps t, which are those of the lead that are kept."""
        stamps, values = one
        if stamps is lead or np.array_equal(stamps, lead):
            return values if keep.all() else values[keep]
        zero = int(t[0])
        found = np.interp((t - zero) * 1e-9, (stamps - zero) * 1e-9, values)
        if not needed:
            own = max(_step(stamps), _step(lead))
            outside = (t < stamps[0] - own) | (t > stamps[-1] + own)
            found[outside | _within_holes(t, stamps, HOLE * own)] = np.nan
        return np.asarray(found)

    def _leave_out_speeds(self, columns: dict[str, Array]) -> None:
        """Speeds are never needed, and nothing can be done with holes in them."""
        speeds = [field for field in self._meant.values() if field.startswith("dq")]
        holes = sum(int(np.isnan(columns[f]).sum()) for f in speeds if f in columns)
        if holes:
            self._remarks.append(f"velocity has {holes} values that are none: left out")
            for field in speeds:
                columns.pop(field, None)


def _prefixes(have: set[str], joints: Sequence[str]) -> list[str]:
    """What stands before every one of the joints' names, such as left_."""
    ends = {name.removesuffix(joints[0]) for name in have if name.endswith(joints[0])}
    return sorted(p for p in ends if all(f"{p}{joint}" in have for joint in joints))


def _joints(names: Sequence[str]) -> str:
    return ", ".join(dict.fromkeys(name.rpartition(".")[0] for name in names))


def _step(stamps: Stamps) -> float:
    """The usual one, ns."""
    steps = np.diff(stamps)
    steps = steps[steps > 0]
    return float(np.median(steps)) if len(steps) else float(SECOND)


def _within_holes(t: Stamps, stamps: Stamps, longest: float) -> NDArray[np.bool_]:
    """Which t lie strictly between two stamps that are further apart."""
    holes = np.flatnonzero(np.diff(stamps) > longest)
    out = np.zeros(len(t), bool)
    for k in holes:
        out[np.searchsorted(t, stamps[k], "right") : np.searchsorted(t, stamps[k + 1], "left")] = (
            True
        )
    return out
