"""Rows of ROS messages that were echoed as text: joints by the names that stand in the rows."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.readers import decimals
from pa10d.store.channels import Array

KINDS = ("position", "velocity", "effort")
WORDS = ("frame_id", "name.")  # columns of words that rows of joint states have
_PLOT = "%time,"  # how rostopic echo -p begins
_NAME = re.compile(r"(?:field\.)?name[._\[]?(\d+)\]?")
_VALUE = re.compile(rf"(?:field\.)?({'|'.join(KINDS)})[._\[]?(\d+)\]?")
SECOND = 1e9  # ns


def by_rostopic(line: str) -> bool:
    """Whether a file that begins so was written by ``rostopic echo -p`` of ROS 1."""
    return line.startswith(_PLOT)


def bare_header(line: str) -> str:
    """Its names without the sign that would make them a comment."""
    return line[1:] if by_rostopic(line) else line


def names_its_joints(header: Sequence[str]) -> bool:
    """Whether columns of names stand beside columns of values, as ``name_0`` and ``position_0``."""
    return any(map(_NAME.fullmatch, header)) and any(map(_VALUE.fullmatch, header))


def by_their_names(
    path: Path, found: Mapping[str, Array], words: Mapping[str, Sequence[str]]
) -> tuple[dict[str, Array], dict[str, list[str]]]:
    """The columns of a joint's values as the joint's name beside them calls them, and what words
    are left. UserError where the names change on the way.

    found, words: columns of numbers, and of words, by the names of the header.
    """
    joints: dict[str, str] = {}
    for name, cells in words.items():
        if match := _NAME.fullmatch(name):
            other = next((k for k, cell in enumerate(cells) if cell != cells[0]), None)
            if other is not None:
                raise UserError(
                    f"{path}: column {name}: row {other + 1} names {cells[other]}, the first "
                    f"{cells[0]}; expected one order in all rows"
                )
            joints[match[1]] = cells[0]
    out: dict[str, Array] = {}
    for name, values in found.items():
        match = _VALUE.fullmatch(name)
        joint = joints.get(match[2]) if match else None
        out[f"{joint}.{match[1]}" if match and joint else name] = values
    return out, {name: list(cells) for name, cells in words.items() if not _NAME.fullmatch(name)}


def of_rostopic(found: Mapping[str, Array]) -> dict[str, Array]:
    """What ``rostopic echo -p`` wrote, at the stamps of the headers where those have one."""
    out: dict[str, Array] = {}
    stamps = found.get("field.header.stamp")
    clock = stamps if stamps is not None and (stamps > 0).all() else found.get("time")
    if clock is not None and len(clock):
        out["time"] = (clock - clock[0] // SECOND * SECOND) / SECOND
    for name, values in found.items():
        if name not in ("time", "field.header.stamp", "field.header.seq"):
            out[name.removeprefix("field.")] = values
    return out


def by_ros2_topic(rows: Sequence[Sequence[str]]) -> list[str]:
    """Names for the rows of ``ros2 topic echo --csv`` of joint states: seconds, nanoseconds, a
    frame, the joints' names, their positions, speeds and efforts. rows: the first two."""
    if len(rows) < 2 or len(rows[0]) < 6 or not all(row and row[0].isdigit() for row in rows):
        return []
    words = [k for k, cell in enumerate(rows[0]) if decimals.Style().number(cell) is None]
    joints = [rows[0][k] for k in words if k > 2]
    numbers = len(rows[0]) - 3 - len(joints)
    told = (
        joints
        and words[-len(joints) :] == list(range(3, 3 + len(joints)))
        and rows[0][1].isdigit()
        and numbers == len(KINDS) * len(joints)  # of two it is not said which two
        and rows[0][2 : 3 + len(joints)] == rows[1][2 : 3 + len(joints)]
    )
    if not told:
        return []
    blocks = [f"{joint}.{kind}" for kind in KINDS for joint in joints]
    return ["sec", "nanosec", "frame_id", *(f"name.{joint}" for joint in joints), *blocks]
