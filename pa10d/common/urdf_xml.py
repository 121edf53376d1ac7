"""A URDF's XML, in whatever encoding it says that it is in."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET
from xml.parsers import expat

OF_NUMBERS = frozenset(
    {"mass", "inertia", "origin", "axis", "limit", "dynamics", "safety_controller", "calibration"}
)
"""Elements all of whose attributes are numbers."""
MOST_SPEED, MOST_TORQUE = 1e3, 1e6  # rad/s, N·m: no arm has more
SAID_OF_LIMITS = {"velocity": MOST_SPEED, "effort": MOST_TORQUE}


def urdf_root(content: str | bytes | Path) -> ET.Element:
    """The top element of a text or a file; OSError where there is no file, ValueError with what is
    wrong where it is no XML. Blanks before the declaration and around numbers are forgiven: other
    parsers take a body whose mass ends with a blank for one without mass. A prefix that nothing
    declares (``<sensor:camera>`` in a simulator's part of the file) is a part of the name, as it
    is to the parsers of ROS. A largest speed or torque that is left out, or is a mere placeholder
    (a velocity of 10000), is 0, which stands for unknown."""
    raw = (content.read_bytes() if isinstance(content, Path) else content).strip()
    try:
        root = _parsed(raw)
    except (ET.ParseError, expat.ExpatError, LookupError) as error:
        raise ValueError(str(error)) from error  # LookupError: an encoding that nobody knows
    for element in root.iter():
        if element.tag in OF_NUMBERS:
            element.attrib.update({key: text.strip() for key, text in element.attrib.items()})
    for limit in root.iterfind("joint/limit"):
        for key, most in SAID_OF_LIMITS.items():
            if _above(limit.get(key, "inf"), most):
                limit.set(key, "0")
    return root


def _above(text: str, most: float) -> bool:
    try:
        return float(text) > most
    except ValueError:  # which is said by who checks the numbers
        return False


def _parsed(raw: str | bytes) -> ET.Element:
    try:
        return ET.fromstring(raw)
    except ET.ParseError as error:
        if error.code != expat.errors.codes[expat.errors.XML_ERROR_UNBOUND_PREFIX]:
            raise
    return _without_namespaces(raw)


def _without_namespaces(raw: str | bytes) -> ET.Element:
    tree, parser = ET.TreeBuilder(), expat.ParserCreate()
    parser.StartElementHandler = tree.start
    parser.EndElementHandler = tree.end
    parser.CharacterDataHandler = tree.data
    parser.Parse(raw, True)
    return tree.close()
