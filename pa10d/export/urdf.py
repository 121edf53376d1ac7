"""The identified rigid bodies as the inertial elements of a URDF."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.export.words import grouped, in_comment
from pa10d.model import TorqueModel

Array = NDArray[np.float64]

CARRIED = ("damping", "friction")  # joint properties that a URDF has
UNLIMITED = 1e8  # rad: wider limits stand for a joint that turns for ever


def urdf_with_inertia(model: TorqueModel, about: str) -> tuple[str, list[str]]:
    """The URDF's text, and one line per effect that a URDF has no place for.

    Every moving link gets the model's feasible standard parameters; whatever is fixed to it is
    in them, so those links lose their own inertial elements. Links that the joints do not
    carry keep theirs. Coulomb and viscous friction of the feasible set go into <dynamics>: a
    free fit may have them negative.
    """
    if model.standard is None:
        raise UserError(
            f"model {model.name!r} has no feasible standard parameters, and base parameters alone "
            "do not make a URDF; expected a model whose identification found some"
        )
    root = ET.fromstring(model.robot.urdf)
    joints = {joint.get("name", ""): joint for joint in root.findall("joint")}
    links = {link.get("name", ""): link for link in root.findall("link")}
    moving = set(model.robot.joint_names)
    locked = []
    for j, name in enumerate(model.robot.joint_names):
        child = _child(joints[name])
        for link in _rigidly_attached(root, child, moving):
            _drop(links[link], "inertial")
        links[child].insert(0, _inertial(model.standard[j], name))
        _friction(joints[name], model, j)
        _restore_continuous(joints[name])
    for name, joint in joints.items():
        if name not in moving and joint.get("type") not in ("fixed", None):
            locked.append(f"joint {name} was locked at zero: its links are part of the one below")
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode")
    comment = f"<!-- inertias identified by pa10d: {in_comment(about)} -->"
    missing = [t for t in model.terms if t.effect.joint_property not in CARRIED]
    lost = [
        f"{label} not in the export: a URDF knows rigid bodies, Coulomb and viscous friction only"
        for label in grouped(missing)
    ]
    return f'<?xml version="1.0"?>\n{comment}\n{text}\n', lost + locked


def inertial_of(parameters: Array) -> tuple[float, Array, Array]:
    """Mass kg, centre of mass (3,) m and inertia (3, 3) kg·m² about it, of standard parameters
    (10,) about the frame's origin (parallel axes: I_c = I_o - m(c·c·1 - c cᵀ))."""
    m = float(parameters[0])
    c = parameters[1:4] / m
    about_origin = parameters[[4, 5, 7, 5, 6, 8, 7, 8, 9]].reshape(3, 3)
    return m, c, about_origin - m * (c @ c * np.eye(3) - np.outer(c, c))


def joint_property(model: TorqueModel, j: int, key: str) -> float:
    """Armature, damping or friction of a joint, by all effects that it is made of."""
    return sum(
        term.effect.as_property(term.coefficients, term.shape)
        for term in model.terms
        if term.effect.joint_property == key and term.joints == (j,)
    )


def possible_mass(parameters: Array, joint: str) -> Array:
    """The same standard parameters (10,); those of no body are refused."""
    if parameters[0] <= 0:
        raise UserError(
            f"joint {joint}: link mass {parameters[0]:g} kg, expected more than zero: the model's "
            "standard parameters are not feasible"
        )
    return parameters


def _inertial(parameters: Array, joint: str) -> ET.Element:
    mass, com, inertia = inertial_of(possible_mass(parameters, joint))
    element = ET.Element("inertial")
    ET.SubElement(element, "origin", xyz=" ".join(_text(v) for v in com), rpy="0 0 0")
    ET.SubElement(element, "mass", value=_text(mass))
    rows = (
        ("ixx", 0, 0),
        ("ixy", 0, 1),
        ("ixz", 0, 2),
        ("iyy", 1, 1),
        ("iyz", 1, 2),
        ("izz", 2, 2),
    )
    ET.SubElement(element, "inertia", {key: _text(inertia[i, k]) for key, i, k in rows})
    return element


def _friction(joint: ET.Element, model: TorqueModel, j: int) -> None:
    found = {key: _text(joint_property(model, j, key)) for key in CARRIED}
    _drop(joint, "dynamics")
    ET.SubElement(joint, "dynamics", found)


def _rigidly_attached(root: ET.Element, link: str, moving: set[str]) -> list[str]:
    """The link and all that hangs on it without one of the moving joints between."""
    found = [link]
    for above in found:
        for joint in root.findall("joint"):
            if _parent(joint) == above and joint.get("name") not in moving:
                found.append(_child(joint))
    return found


def _restore_continuous(joint: ET.Element) -> None:
    limit = joint.find("limit")
    if limit is None or joint.get("type") != "revolute":
        return
    if float(limit.get("upper", 0)) - float(limit.get("lower", 0)) > UNLIMITED:
        joint.set("type", "continuous")
        for key in ("lower", "upper"):
            limit.attrib.pop(key, None)


def _drop(element: ET.Element, tag: str) -> None:
    for child in element.findall(tag):
        element.remove(child)


def _child(joint: ET.Element) -> str:
    return _end(joint, "child")


def _parent(joint: ET.Element) -> str:
    return _end(joint, "parent")


def _end(joint: ET.Element, tag: str) -> str:
    element = joint.find(tag)
    return "" if element is None else element.get("link", "")


def _text(value: float) -> str:
    return repr(float(value))
