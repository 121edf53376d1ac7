"""A URDF's XML, in whatever encoding it says that it is in."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

OF_NUMBERS = frozenset(
    {"mass", "inertia", "origin", "axis", "limit", "dynamics", "safety_controller", "calibration"}
)
"""Elements all of whose attributes are numbers."""


def urdf_root(content: str | bytes | Path) -> ET.Element:
    """The top element of a text or a file; OSError where there is no file, ValueError with what is
    wrong where it is no XML. Blanks before the declaration and around numbers are forgiven: other
    parsers take a body whose mass ends with a blank for one without mass."""
    raw = content.read_bytes() if isinstance(content, Path) else content
    try:
        root = ET.fromstring(raw.strip())
    except (ET.ParseError, LookupError) as error:  # LookupError: an encoding that nobody knows
        raise ValueError(str(error)) from error
    for element in root.iter():
        if element.tag in OF_NUMBERS:
            element.attrib.update({key: text.strip() for key, text in element.attrib.items()})
    return root
