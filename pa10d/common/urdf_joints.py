"""Which joints a URDF has, in the order that they are counted in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from xml.etree import ElementTree as ET

MOVING = ("revolute", "continuous", "prismatic")


def movable_joints(root: ET.Element) -> list[str]:
    """Names of those that move by themselves, in the order of the file; from the base to the tip
    where the file has a joint before one that carries it."""
    written = [joint.get("name", "") for joint in root.findall("joint") if _moves(joint)]
    hung: dict[str, list[ET.Element]] = {}
    for joint in root.findall("joint"):
        hung.setdefault(_link(joint, "parent"), []).append(joint)
    carried = {_link(joint, "child") for joint in root.findall("joint")}
    found = [one for link in hung if link not in carried for one in _from(link, hung, ())]
    names = [name for name, _ in found]
    if sorted(names) != sorted(written):
        return written  # no tree, which is said by who reads it
    place = {name: k for k, name in enumerate(written)}
    upright = all(place[above] < place[name] for name, carriers in found for above in carriers)
    return written if upright else names


def followers(root: ET.Element) -> dict[str, str]:
    """Joints that do not move by themselves -> the one that moves them, through others as well."""
    mimics = [(joint.get("name", ""), joint.find("mimic")) for joint in root.findall("joint")]
    leads = {name: mimic.get("joint", "") for name, mimic in mimics if mimic is not None}
    found = {}
    for name in leads:
        lead, seen = leads[name], {name}
        while lead in leads and lead not in seen:
            seen.add(lead)
            lead = leads[lead]
        found[name] = lead
    return found


def carried_by(root: ET.Element, joint: str) -> set[str]:
    """Names of the joints, of whatever kind, that hang on the link that a joint moves."""
    joints = root.findall("joint")
    links = {_link(one, "child") for one in joints if one.get("name") == joint}
    found: set[str] = set()
    while links:
        hung = [one for one in joints if _link(one, "parent") in links]
        links = {_link(one, "child") for one in hung if one.get("name", "") not in found}
        found |= {one.get("name", "") for one in hung}
    return found


def tell_apart(root: ET.Element) -> None:
    """Links that are called like a joint get a name of their own: Pinocchio cannot hold a joint
    still where they are not told apart."""
    joints = {joint.get("name", "") for joint in root.findall("joint")}
    taken = joints | {link.get("name", "") for link in root.findall("link")}
    for link in root.findall("link"):
        old = link.get("name", "")
        if old not in joints:
            continue
        new = f"{old}_link"
        while new in taken:
            new += "_"
        taken.add(new)
        link.set("name", new)
        for end in (*root.findall("joint/parent"), *root.findall("joint/child")):
            if end.get("link") == old:
                end.set("link", new)


def _from(
    link: str, hung: Mapping[str, Sequence[ET.Element]], carriers: tuple[str, ...]
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Movable joints beyond a link, branch by branch, each with those that carry it."""
    for joint in hung.get(link, ()):
        name, moves = joint.get("name", ""), _moves(joint)
        if moves:
            yield name, carriers
        yield from _from(_link(joint, "child"), hung, (*carriers, name) if moves else carriers)


def _moves(joint: ET.Element) -> bool:
    return joint.get("type") in MOVING and joint.find("mimic") is None


def _link(joint: ET.Element, role: str) -> str:
    end = joint.find(role)
    return "" if end is None else end.get("link", "")
