"""A URDF's XML, in whatever encoding it says that it is in."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET


def urdf_root(content: str | bytes | Path) -> ET.Element:
    """The top element of a text or a file; OSError where there is no file, ValueError with what is
    wrong where it is no XML. Blank lines before the declaration are forgiven."""
    raw = content.read_bytes() if isinstance(content, Path) else content
    try:
        return ET.fromstring(raw.strip())
    except (ET.ParseError, LookupError) as error:  # LookupError: an encoding that nobody knows
        raise ValueError(str(error)) from error
