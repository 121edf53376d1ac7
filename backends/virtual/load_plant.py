"""The plant that a profile names, checked and warmed up."""

from __future__ import annotations

from typing import Any

import numpy as np

from backends.registry import load_object
from backends.virtual.drives.mechanics import INNER_STEP
from pa10d.common.errors import UserError
from pa10d.profile import Profile, Simulation


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
    plant.reset(np.zeros(axes))
    for dt in (1.0 / profile.control.rate, INNER_STEP):  # whatever compiles does so now
        plant.step(np.zeros(axes), dt)
    plant.reset(np.zeros(axes))
    return plant
