"""From a profile and the options in it to a simulated arm."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from backends.virtual.plant.arm import (
    Arm,
    arm_of_model,
    base_gravity,
    perturbed,
    reduced_model,
    with_body,
    with_gravity_turned,
)
from backends.virtual.plant.bristles import bristles_of
from backends.virtual.plant.extras import extras_of
from backends.virtual.plant.friction import friction_of
from backends.virtual.plant.gather import of
from backends.virtual.plant.hidden import Hidden
from backends.virtual.plant.records import Array
from backends.virtual.plant.state import Physics
from backends.virtual.plant.substeps import inertias
from backends.virtual.plant.textbook import Textbook
from backends.virtual.plant.transmission import transmission_of
from backends.virtual.plant.warmth import warmth_of
from pa10d.common.errors import UserError
from pa10d.profile import Profile


def true_arm(profile: Profile, model: pin.Model, spread: float, rng: np.random.Generator) -> Arm:
    """The links as they are: the URDF's, made this arm's own, with the profile's tool."""
    arm = perturbed(arm_of_model(model, base_gravity(profile)), rng, spread)
    if profile.tool is None:
        return arm
    tool = profile.tool
    return with_body(arm, tool.mass, np.asarray(tool.com), symmetric(tool.inertia))


def symmetric(six: Any) -> Array:
    """3 × 3 from Ixx Iyy Izz Ixy Ixz Iyz."""
    if len(six) != 6:
        raise UserError(f"inertia: found {len(six)} numbers, expected Ixx Iyy Izz Ixy Ixz Iyz")
    xx, yy, zz, xy, xz, yz = (float(v) for v in six)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def with_effects(arm: Arm, effects: list[Hidden]) -> Arm:
    """The links with a hidden payload and the base with a hidden lean."""
    for load in of(effects, "payload"):
        com = np.array([load["cx"], load["cy"], load["cz"]])
        arm = with_body(arm, load["mass"], com, symmetric(load.values["inertia"]))
    for lean in of(effects, "base_tilt"):
        arm = with_gravity_turned(arm, lean["x"], lean["y"])
    return arm


def physics_of(arm: Arm, book: Textbook, effects: list[Hidden]) -> Physics:
    """All mechanisms of the arm with the given effects."""
    n = len(arm.mass)
    physics = Physics(
        arm=with_effects(arm, effects),
        friction=friction_of(effects, book.coulomb, book.viscous),
        warmth=warmth_of(effects, n),
        bristles=bristles_of(effects, n),
        transmission=transmission_of(effects, book.rotor_inertia),
        extras=extras_of(effects),
    )
    if np.min(np.linalg.eigvalsh(inertias(physics))) <= 0:
        raise UserError("coupling_inertia: larger than the joints' own inertias can carry")
    return physics


def arm_model(profile: Profile) -> pin.Model:
    """Pinocchio's model of the profile's arm, as its URDF has it."""
    return reduced_model(profile.urdf, profile.joints)
