"""The way back inside, as a file for the loop."""

from __future__ import annotations

import numpy as np

from pa10d.experiments.way_back import rows_back
from pa10d.services.robots import load_robot


def plan_way_back(profile: str, start: list[float], file: str) -> int:
    """From ``start`` rad, into ``file`` → how many rows."""
    found, robot = load_robot(profile)
    rows = rows_back(robot, np.array(start), found.control.rate)
    np.save(file, rows)
    return len(rows)
