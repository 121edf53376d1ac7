"""The robot: a URDF, or a profile that names one."""

from __future__ import annotations

import os
from collections.abc import Hashable

from pa10d import dynamics
from pa10d.face.values import ByContent, settled
from pa10d.profile import Profile
from pa10d.services import robots


class Robot(ByContent):
    """A robot's kinematics, limits and all else that its profile says; joints count from 1.

    name    as the URDF has it
    joints  names of its movable joints, in the order of every array's columns
    """

    def __init__(self, profile: Profile, tree: dynamics.Robot) -> None:
        self.profile, self.tree = profile, tree

    @property
    def name(self) -> str:
        return self.tree.name

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(self.tree.joint_names)

    @property
    def content(self) -> Hashable:
        told = self.profile.model_dump(mode="json", exclude={"path", "urdf"})
        return settled(told), self.tree.urdf

    def _page(self) -> str:
        from pa10d.report.notebook import robot_page

        return robot_page(self.tree)

    def __repr__(self) -> str:
        return f"<Robot {self.name}: {len(self.joints)} joints ({', '.join(self.joints)})>"


def load_robot(path: str | os.PathLike[str]) -> Robot:
    """A robot from a URDF file (meshes are never needed), a profile, or the name of a shipped one.

    Raises UserError with one line that says what is wrong, where, and what was expected.
    """
    return Robot(*robots.load_robot(path))
