"""Which formats there are, and how their files end; light, for command lines and schemas."""

from __future__ import annotations

from typing import Literal, get_args

Format = Literal[
    "urdf", "mjcf", "sdf", "python", "c", "matlab", "json", "ros2_control", "tables"
]  # fmt: skip
FORMATS: tuple[Format, ...] = get_args(Format)
ENDINGS: dict[Format, str] = {
    "urdf": "urdf",
    "mjcf": "xml",
    "sdf": "sdf",
    "python": "py",
    "c": "h",
    "matlab": "m",
    "json": "json",
    "ros2_control": "zip",
    "tables": "zip",
}
FOLDERS: tuple[Format, ...] = ("ros2_control", "tables")
"""Formats of several files: a folder on disk, packed where one file has to do."""

Files = dict[str, str]
"""Path within such a folder -> text."""
