"""All figures of one comparison, by name: what the report and the page both show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.common.jsonable import JsonObject
from pa10d.compare import Comparison
from pa10d.figures.errors import error_maps
from pa10d.figures.memory import memory
from pa10d.figures.overview import overview
from pa10d.figures.plotly import Figure
from pa10d.figures.spectra import spectra
from pa10d.figures.staircase import Stair, staircase
from pa10d.figures.time import torque_over_time


def comparison_figures(comparison: Comparison, steps: Sequence[Stair] = ()) -> JsonObject:
    """``overview``, ``staircase`` (null for a single version) and per joint ``joints``: see
    joint_figures. ``steps``: earlier versions and this one on the same runs."""
    joints, pooled = comparison.model.robot.joint_names, comparison.pooled
    several = len(steps) > 1
    return {
        "overview": overview(pooled, joints, units(comparison)),
        "staircase": staircase(steps, joints, pooled.noise_floor) if several else None,
        "joints": [joint_figures(comparison, j) for j in range(len(joints))],
    }


def joint_figures(comparison: Comparison, joint: int) -> JsonObject:
    """One joint (0-based): ``time`` (run name -> figure), ``maps``, ``spectra``, ``memory``."""
    level = float(comparison.pooled.noise_floor[joint])
    floor = level if np.isfinite(level) else None
    over_time: dict[str, Figure] = {}
    for run in comparison.residuals:
        name, again = run.name, 1
        while name in over_time:  # two runs may share a name
            again += 1
            name = f"{run.name} ({again})"
        over_time[name] = torque_over_time(run, joint, floor)
    return {
        "time": over_time,
        "maps": error_maps(comparison.residuals, joint, comparison.pooled.where, floor),
        "spectra": spectra(
            comparison.orders[joint],
            comparison.frequencies[joint],
            comparison.model.cutoff,
            units(comparison)[joint],
        ),
        "memory": memory(comparison.whiteness[joint]),
    }


def units(comparison: Comparison) -> list[str]:
    """Of each joint's torque."""
    robot = comparison.model.robot
    return [robot.torque_unit(j) for j in range(robot.n)]
