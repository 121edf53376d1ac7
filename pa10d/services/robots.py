"""A profile together with the robot it describes, checked against each other."""

from __future__ import annotations

import os

from pa10d.common.errors import UserError
from pa10d.dynamics.robot import Robot, robot_from_profile
from pa10d.profile import Profile, load_profile


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
