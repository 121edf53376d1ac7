"""Rotor inertia, Coulomb and viscous friction of the drives, given or by the joint's size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from backends.scaling import nameplate
from backends.virtual.plant.records import Array
from pa10d.common.errors import UserError
from pa10d.profile import Profile

DYNAMICS = ("rotor_inertia", "coulomb", "viscous")


@dataclass(frozen=True)
class Textbook:
    """Per joint (n,): kg·m², N·m, N·m·s/rad at the joint side; effort: peak torque, N·m."""

    rotor_inertia: Array
    coulomb: Array
    viscous: Array
    effort: Array


def peak_torques(model: pin.Model, profile: Profile) -> Array:
    """Peak torque per joint: the drive's own, whatever it is limited to, else the profile's limit,
    else the URDF's, else 100 N·m."""
    drives = profile.drives or []
    if len(drives) == len(model.effortLimit):
        return np.array([float(f"{nameplate(drive).rated:.12g}") for drive in drives])
    if profile.limits.torque is not None:
        return np.asarray(profile.limits.torque, float)
    effort = np.asarray(model.effortLimit, float)
    return np.where(np.isfinite(effort) & (effort > 0) & (effort < 1e6), effort, 100.0)


def default_textbook(effort: Array) -> Textbook:
    """Drive figures that grow with the joint's size; they meet the PA10's at 232, 100, 14.5 N·m."""
    size = effort / 232.0
    return Textbook(0.75 * size**1.75, 8.0 * size**0.83, 10.0 * size**0.83, effort)


def textbook_of(effort: Array, given: Mapping[str, Any], rng: np.random.Generator) -> Textbook:
    """Defaults, scattered by ``spread`` of the options, then overruled by given values."""
    base = default_textbook(effort)
    spread = 2.0 * float(given.get("spread", 0.0))
    values: dict[str, Array] = {}
    for key in DYNAMICS:
        scatter = np.exp(spread * rng.uniform(-1, 1, len(effort)))
        values[key] = getattr(base, key) * scatter
        if key in given:
            values[key] = np.broadcast_to(np.asarray(given[key], float), effort.shape).copy()
            if np.any(values[key] < 0):
                raise UserError(f"simulation.options.dynamics.{key}: found a negative value")
    return Textbook(**values, effort=effort)
