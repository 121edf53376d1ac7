"""The identified rigid bodies and textbook friction as an SDFormat model, for Gazebo."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable

import numpy as np
import scipy

from pa10d.export.urdf import CARRIED, inertial_of, joint_property, possible_mass
from pa10d.export.words import grouped, in_comment
from pa10d.model import TorqueModel

PLACES = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))


def sdf(model: TorqueModel, about: str) -> tuple[str, list[str]]:
    """The SDF's text, and one line per effect that it has no place for.

    Each link's frame is its joint's; links are named after the joints they hang on. Gravity is the
    world's and not the model's.
    """
    robot = model.robot
    root = ET.Element("sdf", version="1.9")
    arm = ET.SubElement(root, "model", name=robot.name)
    for j in map(int, robot.order):
        name, above = robot.joint_names[j], int(robot.parent[j])
        parent = _link(robot.joint_names[above]) if above >= 0 else "world"
        link = ET.SubElement(arm, "link", name=_link(name))
        turn = scipy.spatial.transform.Rotation.from_matrix(robot.rotation[j]).as_euler("xyz")
        pose = _add(link, "pose", [*robot.translation[j], *turn])
        if above >= 0:
            pose.set("relative_to", parent)
        assert model.standard is not None
        mass, com, inertia = inertial_of(possible_mass(model.standard[j], name))
        inertial = ET.SubElement(link, "inertial")
        _add(inertial, "pose", [*com, 0.0, 0.0, 0.0])
        _add(inertial, "mass", [mass])
        tensor = ET.SubElement(inertial, "inertia")
        for key, i, k in PLACES:
            _add(tensor, key, [inertia[i, k]])
        kind = "prismatic" if robot.prismatic[j] else "revolute"
        joint = ET.SubElement(arm, "joint", name=name, type=kind)
        ET.SubElement(joint, "parent").text = parent
        ET.SubElement(joint, "child").text = _link(name)
        axis = ET.SubElement(joint, "axis")
        _add(axis, "xyz", robot.axis[j])
        limit = ET.SubElement(axis, "limit")
        for key in ("lower", "upper", "velocity", "effort"):
            if np.isfinite(getattr(robot, key)[j]):
                _add(limit, key, [getattr(robot, key)[j]])
        dynamics = ET.SubElement(axis, "dynamics")
        for key in CARRIED:
            _add(dynamics, key, [joint_property(model, j, key)])
    ET.indent(root)
    gravity = " ".join(repr(float(g)) for g in robot.gravity)
    said = f"identified by pa10d: {about}; gravity, which is the world's: {gravity}"
    missing = [t for t in model.terms if t.effect.joint_property not in CARRIED]
    lost = [
        f"{label} not in the export: SDF knows rigid bodies, Coulomb and viscous friction only"
        for label in grouped(missing)
    ]
    text = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0"?>\n<!-- {in_comment(said)} -->\n{text}\n', lost


def _link(joint: str) -> str:
    return f"{joint}_link"


def _add(parent: ET.Element, tag: str, values: Iterable[float]) -> ET.Element:
    element = ET.SubElement(parent, tag)
    element.text = " ".join(repr(float(v)) for v in values)
    return element
