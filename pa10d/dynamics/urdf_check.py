"""What a URDF must get right before its tree can be built: one line per fault, naming the element.

Pinocchio's parser answers a faulty file with several lines of its own on stderr, or with a robot
whose masses are silently zero. So everything it would stumble over is looked at here first.
Meshes, materials and everything else that dynamics does not need is passed over.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator

from pa10d.common.errors import UserError

TYPES = ("revolute", "continuous", "prismatic", "fixed")
MOST_JOINTS = 500  # a robot has a hundred; its tree is walked along, joint by joint
INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def check_urdf(root: ET.Element, where: str) -> None:
    """Raise UserError for the first fault; ``where``: the file, as messages begin."""
    fault = next(_faults(root), None)
    if fault is not None:
        raise UserError(f"{where}: {fault}")


def _faults(root: ET.Element) -> Iterator[str]:
    if root.tag != "robot":
        yield f"found <{root.tag}>, expected <robot> at the top of a URDF"
    if (count := len(root.findall("joint"))) > MOST_JOINTS:
        yield f"found {count} joints, expected {MOST_JOINTS} at most"
    for tag in ("link", "joint"):
        yield from _names(root, tag)
    for link in root.findall("link"):
        yield from _link(link, f"link {link.get('name')!r}")
    links = {link.get("name", "") for link in root.findall("link")}
    joints = {joint.get("name", "") for joint in root.findall("joint")}
    for joint in root.findall("joint"):
        label = f"joint {joint.get('name')!r}"
        yield from _joint(joint, label, links)
        yield from _mimic(joint, label, joints)
    yield from _tree(root, links)


def _names(root: ET.Element, tag: str) -> Iterator[str]:
    names = Counter(element.get("name", "") for element in root.findall(tag))
    if "" in names:
        yield f"found a <{tag}> without a name, expected one"
    for name, count in names.items():
        if count > 1:
            yield f"{tag} {name!r}: found {count} times, expected once"


def _link(link: ET.Element, label: str) -> Iterator[str]:
    inertial = link.find("inertial")
    if inertial is None:
        return
    yield from _origin(inertial, label)
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        missing = "mass" if mass is None else "inertia"
        yield f"{label}: found <inertial> without <{missing}>, expected both mass and inertia"
        return
    yield from _number(mass, "value", label, required=True)
    for name in INERTIA:
        yield from _number(inertia, name, label, required=True)
    if float(mass.get("value", "0")) < 0:
        yield f"{label}: found mass {mass.get('value')}, expected 0 or more"


def _joint(joint: ET.Element, label: str, links: set[str]) -> Iterator[str]:
    kind = joint.get("type")
    if kind not in TYPES:
        yield f"{label}: found type {kind!r}, expected one of {', '.join(TYPES)}"
    for end in ("parent", "child"):
        element = joint.find(end)
        if element is None:
            yield f"{label}: found no <{end}>, expected the link it joins"
        elif element.get("link") not in links:
            yield f"{label}: found {end} link {element.get('link')!r}, expected one of the file"
    yield from _origin(joint, label)
    axis, limit = joint.find("axis"), joint.find("limit")
    if axis is not None:
        yield from _vector(axis, "xyz", label)
        if kind != "fixed" and not any(map(float, axis.get("xyz", "1 0 0").split())):
            yield f"{label}: found axis 0 0 0, expected a direction"
    if kind in ("revolute", "prismatic"):
        if limit is None:
            hint = " (or type continuous)" if kind == "revolute" else ""
            yield f"{label}: found no <limit>, expected one with effort and velocity{hint}"
            return
        for name in ("lower", "upper", "effort", "velocity"):
            yield from _number(limit, name, label)
        lower, upper = float(limit.get("lower", "0")), float(limit.get("upper", "0"))
        if lower > upper:
            yield f"{label}: found limits {lower:g} … {upper:g}, expected the lower one first"


def _mimic(joint: ET.Element, label: str, joints: set[str]) -> Iterator[str]:
    mimic = joint.find("mimic")
    if mimic is None:
        return
    lead = mimic.get("joint")
    if lead not in joints:
        yield f"{label}: found <mimic joint={lead!r}>, expected a joint that it follows"
    for name in ("multiplier", "offset"):
        yield from _number(mimic, name, label)


def _origin(element: ET.Element, label: str) -> Iterator[str]:
    origin = element.find("origin")
    if origin is not None:
        yield from _vector(origin, "xyz", label)
        yield from _vector(origin, "rpy", label)


def _vector(element: ET.Element, name: str, label: str) -> Iterator[str]:
    text = element.get(name)
    if text is None:
        return
    parts = text.split()
    if len(parts) != 3 or not text.isascii() or not all(map(_finite, parts)):
        yield f"{label}: found <{element.tag} {name}={text!r}>, expected three numbers"


def _number(element: ET.Element, name: str, label: str, required: bool = False) -> Iterator[str]:
    text = element.get(name)
    if text is None:
        if required:
            yield f"{label}: found <{element.tag}> without {name}, expected a number"
    elif not _finite(text):
        yield f"{label}: found <{element.tag} {name}={text!r}>, expected a number"


def _finite(text: str) -> bool:
    try:
        return math.isfinite(float(text)) and "_" not in text and text.isascii()
    except ValueError:
        return False


def _tree(root: ET.Element, links: set[str]) -> Iterator[str]:
    """Every link hangs on one joint, all of them on one root."""
    parent_of: dict[str, str] = {}
    for joint in root.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is None or child is None:
            return
        name = child.get("link", "")
        if name in parent_of:
            yield f"link {name!r}: found as the child of two joints, expected of one"
        parent_of[name] = parent.get("link", "")
    if not links:
        yield "found no <link>, expected the bodies of a robot"
        return
    roots = sorted(links - parent_of.keys())
    if len(roots) > 1:
        yield f"found {len(roots)} links without a parent ({', '.join(roots)}), expected one base"
    for link in sorted(links):
        seen = {link}
        while link in parent_of:
            link = parent_of[link]
            if link in seen:
                yield f"link {link!r}: found in a closed chain, expected a tree"
                return
            seen.add(link)
