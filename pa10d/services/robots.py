"""A profile together with the robot it describes, checked against each other."""

from __future__ import annotations

import os

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.dynamics.robot import Robot, robot_from_profile
from pa10d.profile import Profile, load_profile
from pa10d.profile.load import profile_folders


def load_robot(name: str | os.PathLike[str]) -> tuple[Profile, Robot]:
    """The profile of this name or path and its arm; every per-joint list fits the arm."""
    profile = load_profile(name)
    robot = robot_from_profile(profile)
    wrong = [
        f"{profile.path}: {'.'.join(map(str, place))}: found {len(values)} entries, expected "
        f"{robot.n}, one for each joint of {robot.name} ({', '.join(robot.joint_names)})"
        for place, values in profile.per_joint().items()
        if len(values) != robot.n
    ]
    if wrong:
        raise UserError("\n".join(wrong))
    return profile, robot


def shipped_robots() -> list[JsonObject]:
    """Name, number of joints and the first sentence of every profile that is known by name."""
    files = {f.stem: f for folder in profile_folders() for f in sorted(folder.glob("*.yaml"))}
    return [
        {"name": name, "joints": load_robot(file)[1].n, "says": _first_sentence(file.read_text())}
        for name, file in sorted(files.items())
    ]


def _first_sentence(text: str) -> str:
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    return " ".join(lines).partition(". ")[0].rstrip(".")
