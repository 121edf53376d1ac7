"""Which formats there are, and how their files end; light, for command lines and schemas."""

from __future__ import annotations

from typing import Literal, get_args

Format = Literal["urdf", "mjcf", "sdf", "python", "c", "matlab", "json"]
FORMATS: tuple[Format, ...] = get_args(Format)
ENDINGS: dict[Format, str] = {
    "urdf": "urdf",
    "mjcf": "xml",
    "sdf": "sdf",
    "python": "py",
    "c": "h",
    "json": "json",
}
