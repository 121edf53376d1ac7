"""A model as tables, for controllers that take nothing else.

Per joint: the torque that holds the arm at rest over the few joints that it depends on most, and
friction over the joint's own speed. The numbers are those of the straight-line code that the C
export consists of. What a table leaves out is averaged over, and its error is told.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.interpolate
import yaml
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.dynamics import Robot
from pa10d.export.endings import Files
from pa10d.export.loss import NOTHING
from pa10d.export.straight_line import forgotten, traceable
from pa10d.export.tabulated import Tabulated
from pa10d.model import TorqueModel

Array = NDArray[np.float64]

MOST_AXES = 3
STEPS = {1: 180, 2: 60, 3: 30}  # of a turn, by the number of axes; three of two turns: 238 328 rows
NEGLIGIBLE = 0.01  # of the torque's own RMS: joints that matter less are left out
USELESS = 0.5  # of the torque's own RMS: a table that is off by more is not written
AVERAGED = 64  # poses of the joints that are left out
JUDGED = 4000  # poses (and speeds) by which a table's error is told
SPEEDS = 40  # to either side of standstill, closer together near it
SLOWEST = 5e-4  # of the speed limit
NO_PLACE = "inertia and Coriolis torque not in the export: tables of poses have no place for it"


@dataclass(frozen=True)
class TorqueTable:
    """One joint's torque over ``axes``: (label, unit, values) each; error: RMS and largest, of the
    torque's own ``size`` (RMS), in the joint's unit; left_out: 0-based joints."""

    joint: int
    axes: tuple[tuple[str, str, Array], ...]
    values: Array
    error: tuple[float, float]
    size: float
    left_out: tuple[int, ...] = ()


def tables(model: TorqueModel, about: str) -> tuple[Files, list[str]]:
    """The folder's files, and one line per thing that they cannot carry."""
    kept, lost = traceable(model)
    source = Tabulated(kept)
    robot, files = kept.robot, {}
    entries: dict[str, list[JsonObject]] = {"holding": [], "friction": []}
    lost = [NO_PLACE, *lost, *forgotten(kept)]
    for j in range(robot.n):
        made = {"holding": holding_table(source, j), "friction": friction_table(source, j)}
        for kind, table in made.items():
            if table is None:
                continue
            if table.error[0] > USELESS * table.size > NOTHING:
                lost.append(_refused(robot, kind, table))
                continue
            name = f"{kind}_{j + 1}.csv"
            files[name] = _csv(table, robot.torque_unit(j))
            entries[kind].append(_entry(robot, table, name))
            if (said := _left_out(robot, kind, table)) is not None:
                lost.append(said)
    lost += [
        f"friction of joint {j + 1} not in the export: no speed limit to end a table at"
        for j in np.flatnonzero(~np.isfinite(robot.velocity))
    ]
    head = {"model": model.name, "about": about, "joints": list(robot.joint_names)}
    text = yaml.safe_dump(
        {**head, "how": HOW, **entries, "not_carried": lost}, sort_keys=False, allow_unicode=True,
        width=100,
    )  # fmt: skip
    return {"tables.yaml": text, **files}, lost


HOW = (
    "Interpolate linearly between rows; the last axis runs fastest. holding: what keeps the joint "
    "where it is. friction: to be added at that speed of the joint itself. error: table minus "
    f"model in {JUDGED} poses drawn within the joint limits, what is left out included."
)


def holding_table(source: Tabulated, j: int) -> TorqueTable:
    """Over the joints that matter most to joint j."""
    reached, poses = source.reached(j), source.poses(JUDGED, seed=1)
    expected = source.holding(j, poses)
    size = _rms(expected)
    axes = _that_matter(source, j, reached, poses, expected)
    labels = _axes(source, axes)
    shape = tuple(len(values) for _, _, values in labels)
    rows = _rows(labels)
    rest = tuple(k for k in reached if k not in axes)
    mean = np.zeros(len(rows))
    others = source.poses(AVERAGED if rest else 1, seed=2)
    for pose in others:
        filled = np.repeat(pose[None], len(rows), axis=0)
        filled[:, axes] = rows
        mean += source.holding(j, filled) / len(others)
    values = mean.reshape(shape)
    return TorqueTable(
        j, labels, values, _error(labels, values, poses[:, axes], expected), size, rest
    )


def friction_table(source: Tabulated, j: int) -> TorqueTable | None:
    """Over the joint's own speed, averaged over poses; None where there is none, or no limit."""
    limit = float(source.robot.velocity[j])
    if not np.isfinite(limit):
        return None
    side = limit * np.geomspace(SLOWEST, 1.0, SPEEDS)
    speed = np.concatenate([-side[::-1], [0.0], side])
    poses = source.poses(AVERAGED, seed=3)
    everywhere = np.repeat(poses, len(speed), axis=0), np.tile(speed, AVERAGED)
    values = source.friction(j, *everywhere).reshape(AVERAGED, -1).mean(axis=0)
    judged = source.poses(JUDGED, seed=4)
    at = np.random.default_rng(5).uniform(-limit, limit, JUDGED)
    expected = source.friction(j, judged, at)
    if _rms(expected) < NOTHING:
        return None
    unit = f"{source.robot.angle_unit(j)}/s"
    axes = ((f"speed of {source.robot.joint_names[j]}", unit, speed),)
    return TorqueTable(j, axes, values, _error(axes, values, at[:, None], expected), _rms(expected))


def _that_matter(
    source: Tabulated, j: int, reached: Sequence[int], poses: Array, expected: Array
) -> list[int]:
    """By what is lost if a joint is drawn anew (half of the mean square: its total effect)."""
    anew, effect = source.poses(JUDGED, seed=6), {}
    for k in reached:
        moved = poses.copy()
        moved[:, k] = anew[:, k]
        effect[k] = 0.5 * np.mean((source.holding(j, moved) - expected) ** 2)
    order = sorted(reached, key=lambda k: -effect[k])
    least = max(NEGLIGIBLE * _rms(expected), NOTHING) ** 2
    return sorted(k for k in order[:MOST_AXES] if effect[k] > least)


def _axes(source: Tabulated, joints: Sequence[int]) -> tuple[tuple[str, str, Array], ...]:
    """At equal steps over each joint's range; one that slides, over as many as a turn has."""
    robot, found = source.robot, []
    for k in joints:
        lower, upper = float(source.lower[k]), float(source.upper[k])
        turn = upper - lower if robot.prismatic[k] else 2.0 * np.pi
        points = max(2, int(np.ceil((upper - lower) / turn * STEPS[len(joints)])) + 1)
        values = np.linspace(lower, upper, points)
        found.append((robot.joint_names[k], robot.angle_unit(k), values))
    return tuple(found)


def _rows(axes: Sequence[tuple[str, str, Array]]) -> Array:
    """(N, axes) of a table, the last axis fastest; one row where there is no axis."""
    grid = np.meshgrid(*(values for _, _, values in axes), indexing="ij")
    return np.stack([g.ravel() for g in grid], axis=1) if axes else np.zeros((1, 0))


def _error(
    axes: Sequence[tuple[str, str, Array]], values: Array, at: Array, expected: Array
) -> tuple[float, float]:
    if not axes:
        off = float(values) - expected
    else:
        grid = [axis[2] for axis in axes]
        off = scipy.interpolate.RegularGridInterpolator(grid, values)(at) - expected
    return _rms(off), float(np.abs(off).max())


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _csv(table: TorqueTable, unit: str) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*(f"{label} [{u}]" for label, u, _ in table.axes), f"effort [{unit}]"])
    rows = np.column_stack([_rows(table.axes), table.values.ravel()])
    writer.writerows([f"{value:.10g}" for value in row] for row in rows)
    return out.getvalue()


def _entry(robot: Robot, table: TorqueTable, file: str) -> JsonObject:
    j = table.joint
    return {
        "joint": robot.joint_names[j],
        "number": j + 1,
        "file": file,
        "unit": robot.torque_unit(j),
        "axes": [
            {"of": label, "unit": unit, "from": float(v[0]), "to": float(v[-1]), "points": len(v)}
            for label, unit, v in table.axes
        ],
        "averaged_over": [robot.joint_names[k] for k in table.left_out],
        "rms": round(table.size, 6),
        "error": {"rms": round(table.error[0], 6), "largest": round(table.error[1], 6)},
    }


def _refused(robot: Robot, kind: str, table: TorqueTable) -> str:
    rms, unit = table.error[0], robot.torque_unit(table.joint)
    over = ", ".join(label for label, _, _ in table.axes)
    return (
        f"{kind} of joint {table.joint + 1} not in the export: a table over {over} would be off by "
        f"{rms:.2g} {unit} (RMS, of {table.size:.3g})"
    )


def _left_out(robot: Robot, kind: str, table: TorqueTable) -> str | None:
    """Where a table is off by more than what counts as nothing."""
    rms, largest = table.error
    if rms <= max(NEGLIGIBLE * table.size, NOTHING):
        return None
    unit = robot.torque_unit(table.joint)
    also = ", ".join(robot.joint_names[k] for k in table.left_out)
    why = f"it depends on {also} as well" if also else "between its rows, or by pose"
    return (
        f"{kind} of joint {table.joint + 1} is off by {rms:.2g} {unit} (RMS, of {table.size:.3g}), "
        f"{largest:.2g} {unit} at most: {why}"
    )
