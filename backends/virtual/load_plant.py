"""The plant that a profile names, checked and warmed up."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from backends.limits import axis_limits
from backends.registry import load_object
from backends.virtual.drives.mechanics import INNER_STEP
from pa10d.common.errors import UserError
from pa10d.profile import Profile, Simulation

INSIDE = 0.05  # rad (m) that zero must be within a joint's limits for an arm to wake up there


def load_plant(profile: Profile, axes: int) -> Any:
    """What the profile puts behind the drives, checked against INTERFACES' plant protocol."""
    simulation = profile.simulation or Simulation()
    where = f"{profile.path}: simulation.plant"
    plant = load_object(simulation.plant, where)(profile, **simulation.options)
    for name in ("n", "reset", "step", "measure"):
        if not hasattr(plant, name):
            raise UserError(f"{where}: '{simulation.plant}' has no '{name}', expected a plant")
    if plant.n != axes:
        raise UserError(f"{where}: {plant.n} joints, expected {axes}: one per drive")
    start = start_pose(profile, axes)
    plant.reset(start)
    for dt in (1.0 / profile.control.rate, INNER_STEP):  # whatever compiles does so now
        plant.step(np.zeros(axes), dt)
    plant.reset(start)
    return plant


def start_pose(profile: Profile, axes: int) -> NDArray[np.float64]:
    """(n,) rad (m): the profile's home, else zero, or mid-range where zero is beyond the limits."""
    if profile.home is not None:
        return np.array(profile.home, dtype=float)
    pose = np.zeros(axes)
    for j, limit in enumerate(axis_limits(profile)):
        if not limit.lower + INSIDE < 0 < limit.upper - INSIDE:
            pose[j] = 0.5 * (limit.lower + limit.upper)
    return pose
