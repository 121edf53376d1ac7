"""The plant that a profile names, checked and warmed up."""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Mapping
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
    plant = made_plant(profile, axes)
    start = start_pose(profile, axes)
    try:
        plant.reset(start)
        for dt in (1.0 / profile.control.rate, INNER_STEP):  # whatever compiles does so now
            plant.step(np.zeros(axes), dt)
        plant.reset(start)
    except UserError:
        raise
    except Exception as error:
        raise UserError(f"{where}: '{simulation.plant}': {_thrown(error)}") from error
    return plant


def made_plant(profile: Profile, axes: int) -> Any:
    """The same, made only: nothing has moved yet, and nothing is compiled."""
    simulation = profile.simulation or Simulation()
    where = f"{profile.path}: simulation.plant"
    factory = load_object(simulation.plant, where)
    _refuse_unknown(factory, simulation.options, profile)
    try:
        plant = factory(profile, **simulation.options)
    except UserError as error:  # of a key: the plant does not know of which file
        raise UserError(_in_file(profile, str(error))) from error
    except Exception as error:  # whatever a factory of others throws, it is said where it is named
        raise UserError(f"{where}: '{simulation.plant}': {_thrown(error)}") from error
    for name in ("n", "reset", "step", "measure"):
        if not hasattr(plant, name):
            raise UserError(f"{where}: '{simulation.plant}' has no '{name}', expected a plant")
    if plant.n != axes:
        raise UserError(f"{where}: {plant.n} joints, expected {axes}: one per drive")
    return plant


def _refuse_unknown(factory: Any, options: Mapping[str, Any], profile: Profile) -> None:
    try:
        taken = list(inspect.signature(factory).parameters.values())[1:]  # without the profile
    except (TypeError, ValueError):  # it does not say what it takes
        return
    if any(one.kind is one.VAR_KEYWORD for one in taken):
        return
    names = [one.name for one in taken]
    for key in options:
        if key not in names:
            raise UserError(
                f"{profile.path}: simulation.options.{key}: found an unknown key, expected one of "
                f"{', '.join(names) or 'none'}"
            )


def _in_file(profile: Profile, line: str) -> str:
    return f"{profile.path}: {line}" if line.startswith(("joints:", "simulation.")) else line


def _thrown(error: Exception) -> str:
    """One line, with the place for who wrote it."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    what = " ".join(str(error).split())
    return f"{type(error).__name__}: {what} ({place.filename}:{place.lineno}); expected a plant"


def start_pose(profile: Profile, axes: int) -> NDArray[np.float64]:
    """(n,) rad (m): the profile's home, else zero, or mid-range where zero is beyond the limits."""
    if profile.home is not None:
        return np.array(profile.home, dtype=float)
    pose = np.zeros(axes)
    for j, limit in enumerate(axis_limits(profile)):
        if not limit.lower + INSIDE < 0 < limit.upper - INSIDE:
            pose[j] = 0.5 * (limit.lower + limit.upper)
    return pose
