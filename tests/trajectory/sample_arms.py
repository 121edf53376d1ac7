"""Arms for the tests of this folder."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from pa10d.dynamics import Robot, robot_from_profile, robot_from_urdf
from pa10d.dynamics.environment import Box, Environment
from pa10d.profile import load_profile
from pa10d.trajectory.poses import Surroundings

JOINT = (
    '<joint name="j{j}" type="{kind}"><parent link="{parent}"/><child link="l{j}"/>'
    '<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
    '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
    '<link name="l{j}"><inertial><origin xyz="0.1 0.05 0.2"/><mass value="1.3"/>'
    '<inertia ixx="0.3" iyy="0.2" izz="0.25" ixy="0.01" ixz="0.02" iyz="0"/></inertial></link>'
)


@cache
def pa10() -> Robot:
    return robot_from_profile(load_profile("pa10-sim"))


def among(robot: Robot, *boxes: Box, floor: float | None = 0.0) -> Robot:
    """The same arm among other things."""
    return replace(robot, environment=Environment(floor, boxes))


def box(size, position, turn=0.0) -> Box:
    """A box turned about a skew axis."""
    axis = np.array([[0, -0.6, 0.8], [0.6, 0, 0], [-0.8, 0, 0]])  # of (0, 0.8, 0.6), as a cross
    rotation = np.eye(3) + np.sin(turn) * axis + (1 - np.cos(turn)) * axis @ axis
    return Box("table", np.array(size), np.array(position), rotation)


@cache
def around_pa10() -> Surroundings:
    return Surroundings.of(pa10())


def random_tree(joints: int, seed: int) -> Robot:
    """A tree with branches and sliding joints at random places."""
    rng = np.random.default_rng(seed)
    text = ""
    for j in range(joints):
        parent = "base" if j == 0 else f"l{rng.integers(max(0, j - 2), j)}"
        xyz, rpy, axis = (" ".join(f"{v:.4f}" for v in rng.normal(size=3)) for _ in range(3))
        kind = "prismatic" if rng.random() < 0.35 else "revolute"
        text += JOINT.format(j=j, kind=kind, parent=parent, xyz=xyz, rpy=rpy, axis=axis)
    return robot_from_urdf(f'<robot name="tree"><link name="base"/>{text}</robot>')
