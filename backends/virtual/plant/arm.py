"""The arm as it really is: rigid links read from the URDF, then made its own by a seed."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from backends.virtual.plant.records import Array, Ints
from pa10d.common.errors import UserError
from pa10d.common.urdf_joints import movable_joints, tell_apart
from pa10d.common.urdf_xml import urdf_root
from pa10d.profile import Profile


class Arm(NamedTuple):
    """Rigid bodies, one per joint; frames are those of the joints (SI, axes at zero pose).

    parent (n,) index of the parent joint or -1; prismatic (n,) 0/1; axis (n, 3) in its own frame;
    rotation (n, 3, 3) and offset (n, 3): placement in the parent's frame at q = 0;
    mass (n,), com (n, 3), inertia (n, 3, 3) about the centre of mass; gravity (3,) in the base.
    """

    parent: Ints
    prismatic: Ints
    axis: Array
    rotation: Array
    offset: Array
    mass: Array
    com: Array
    inertia: Array
    gravity: Array


def reduced_model(urdf: Path, joints: list[str] | None) -> pin.Model:
    """Pinocchio's model of the profile's joints, all others locked at zero."""
    try:
        root = urdf_root(urdf)
        wanted = movable_joints(root) if joints is None else joints
        tell_apart(root)
        full = pin.buildModelFromXML(ET.tostring(root, encoding="unicode"))
    except ValueError as error:
        raise UserError(f"{urdf}: cannot be read as a URDF: {error}") from error
    movable = list(full.names)[1:]
    if missing := [name for name in wanted if name not in movable]:
        raise UserError(f"{urdf}: no joint {missing[0]!r}; expected some of {', '.join(movable)}")
    locked = [full.getJointId(name) for name in movable if name not in wanted]
    model = pin.buildReducedModel(full, locked, pin.neutral(full))
    if list(model.names)[1:] != list(wanted):
        raise UserError(
            f"joints: found {', '.join(wanted)}, expected from base to tip as in {urdf}: "
            f"{', '.join(list(model.names)[1:])}"
        )
    return model


def base_gravity(profile: Profile) -> Array:
    """Gravity in the base frame, m/s², (3,)."""
    if profile.gravity is not None:
        return np.asarray(profile.gravity, float)
    turn = pin.rpy.rpyToMatrix(*(profile.base.rpy if profile.base else (0.0, 0.0, 0.0)))
    return np.asarray(turn.T @ np.array([0.0, 0.0, -9.81]))


def arm_of_model(model: pin.Model, gravity: Array) -> Arm:
    """Read a Pinocchio model of one-degree-of-freedom joints into plain arrays."""
    ids = range(1, model.njoints)
    axes = np.array([_motion_axis(model.joints[i]) for i in ids])
    prismatic = np.linalg.norm(axes[:, :3], axis=1) > 0.5
    axis = np.where(prismatic[:, None], axes[:, :3], axes[:, 3:])
    return Arm(
        parent=np.array([model.parents[i] - 1 for i in ids], np.int64),
        prismatic=prismatic.astype(np.int64),
        axis=np.ascontiguousarray(axis),
        rotation=np.array([model.jointPlacements[i].rotation for i in ids]),
        offset=np.array([model.jointPlacements[i].translation for i in ids]),
        mass=np.array([model.inertias[i].mass for i in ids]),
        com=np.array([model.inertias[i].lever for i in ids]),
        inertia=np.array([model.inertias[i].inertia for i in ids]),
        gravity=np.array(gravity, float),
    )


def _motion_axis(joint: pin.JointModel) -> Array:
    data = joint.createData()
    motion = np.asarray(data.S, float).reshape(6, -1)
    if motion.shape[1] != 1:
        raise UserError(f"URDF: a {joint.shortname()} has {motion.shape[1]} axes, expected one")
    return motion[:, 0]


def perturbed(arm: Arm, rng: np.random.Generator, spread: float) -> Arm:
    """Another arm of the same build: masses ±spread, centres shifted, inertia axes turned.

    Every link stays physically consistent: its inertia is scaled with its mass and rotated.
    """
    n = len(arm.mass)
    factor = 1.0 + spread * rng.uniform(-1, 1, n)
    shift = 0.15 * spread * rng.uniform(-1, 1, (n, 3))
    turns = [pin.exp3(spread * rng.uniform(-1, 1, 3)) for _ in range(n)]
    stretch = 1.0 + spread * rng.uniform(-1, 1, n)
    inertia = [
        f * s * (r @ i @ r.T)
        for f, s, r, i in zip(factor, stretch, turns, arm.inertia, strict=True)
    ]
    return arm._replace(mass=arm.mass * factor, com=arm.com + shift, inertia=np.array(inertia))


def with_body(arm: Arm, mass: float, com: Array, inertia: Array) -> Arm:
    """The arm with a body bolted to its last link (com in its frame, inertia about com)."""
    last = pin.Inertia(float(arm.mass[-1]), arm.com[-1], arm.inertia[-1])
    sum_ = last + pin.Inertia(float(mass), np.asarray(com, float), np.asarray(inertia, float))
    out = arm._replace(mass=arm.mass.copy(), com=arm.com.copy(), inertia=arm.inertia.copy())
    out.mass[-1], out.com[-1], out.inertia[-1] = sum_.mass, sum_.lever, sum_.inertia
    return out


def with_gravity_turned(arm: Arm, about_x: float, about_y: float) -> Arm:
    """The arm on a base leaning by two angles (rad) about its own x and y axes."""
    lean = pin.rpy.rpyToMatrix(about_x, about_y, 0.0)
    return arm._replace(gravity=np.asarray(lean.T @ arm.gravity))


def as_pinocchio(arm: Arm) -> pin.Model:
    """The same arm as a Pinocchio model, for checks and for computing true torques."""
    model = pin.Model()
    for i in range(len(arm.mass)):
        kind = (
            pin.JointModelPrismaticUnaligned
            if arm.prismatic[i]
            else pin.JointModelRevoluteUnaligned
        )
        place = pin.SE3(arm.rotation[i], arm.offset[i])
        added = model.addJoint(int(arm.parent[i]) + 1, kind(arm.axis[i]), place, f"joint{i + 1}")
        body = pin.Inertia(float(arm.mass[i]), arm.com[i], arm.inertia[i])
        model.appendBodyToJoint(added, body, pin.SE3.Identity())
    model.gravity.linear = arm.gravity
    return model
