"""The identified rigid bodies, rotors and textbook friction as a MuJoCo model."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.export.urdf import inertial_of, joint_property, possible_mass
from pa10d.export.words import grouped, in_comment
from pa10d.model import TorqueModel

Array = NDArray[np.float64]

PROPERTIES = {"armature": "armature", "damping": "damping", "friction": "frictionloss"}
"""An effect's joint property -> what MJCF calls it."""
FIRMEST = 0.004  # s: time constant of a constraint, twice MuJoCo's usual step, the least it takes
DRY_LAG = 0.5 * 0.95 * FIRMEST
"""s: a constraint in MuJoCo has friction turn round where speed + this × acceleration passes zero
(its reference is -2/(dmax·time constant) × speed, dmax 0.95)."""


def mjcf(model: TorqueModel, about: str) -> tuple[str, list[str]]:
    """The MJCF's text, and one line per effect that it has no place for.

    Bodies are named after the joints they hang on; without geometry, for the profile needs none.
    """
    robot = model.robot
    root = ET.Element("mujoco", model=robot.name)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    ET.SubElement(root, "option", gravity=_row(robot.gravity))
    place: dict[int, ET.Element] = {-1: ET.SubElement(root, "worldbody")}
    motors = ET.SubElement(root, "actuator")
    for j in map(int, robot.order):
        name = robot.joint_names[j]
        x, y, z, w = scipy.spatial.transform.Rotation.from_matrix(robot.rotation[j]).as_quat()
        body = ET.SubElement(
            place[int(robot.parent[j])],
            "body",
            name=f"{name}_body",
            pos=_row(robot.translation[j]),
            quat=_row([w, x, y, z]),
        )
        place[j] = body
        assert model.standard is not None
        mass, com, inertia = inertial_of(possible_mass(model.standard[j], name))
        full = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        ET.SubElement(body, "inertial", pos=_row(com), mass=_row([mass]), fullinertia=_row(full))
        kind = "slide" if robot.prismatic[j] else "hinge"
        joint = {"name": name, "type": kind, "axis": _row(robot.axis[j])} | _properties(model, j)
        if np.isfinite(robot.lower[j]) and np.isfinite(robot.upper[j]):
            joint["range"] = _row([robot.lower[j], robot.upper[j]])
        ET.SubElement(body, "joint", joint)
        motor = {"name": f"{name}_motor", "joint": name}
        if np.isfinite(robot.effort[j]):
            motor["ctrlrange"] = _row([-robot.effort[j], robot.effort[j]])
        ET.SubElement(motors, "motor", motor)
    ET.indent(root)
    comment = f"<!-- identified by pa10d: {in_comment(about)} -->"
    missing = [t for t in model.terms if t.effect.joint_property not in PROPERTIES]
    lost = [
        f"{label} not in the export: MJCF knows rigid bodies, armature, damping and frictionloss"
        for label in grouped(missing)
    ]
    return f"{comment}\n{ET.tostring(root, encoding='unicode')}\n", lost


def _properties(model: TorqueModel, joint: int) -> dict[str, str]:
    written = {name: _row([joint_property(model, joint, key)]) for key, name in PROPERTIES.items()}
    return written | {"solreffriction": _row([FIRMEST, 1.0])}


def _row(values: NDArray[np.float64] | list[float]) -> str:
    return " ".join(repr(float(v)) for v in values)
