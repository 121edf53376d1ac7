"""Robots of every kind, as URDF text: serial, branched, with prismatic joints."""

from __future__ import annotations

import numpy as np


def urdf(joints: list[dict], seed: int = 0) -> str:
    """One link per joint; a joint: type, parent link (0 = base), optional axis."""
    rng = np.random.default_rng(seed)
    parts = ['<robot name="tree"><link name="l0"/>']
    for i, joint in enumerate(joints, start=1):
        com, (a, b, c) = rng.uniform(-0.2, 0.2, 3), rng.uniform(0.05, 0.3, 3)
        mass = rng.uniform(0.5, 5.0)
        # a brick of sides a, b, c: a body that can exist
        ixx, iyy, izz = (mass / 12 * s for s in (b * b + c * c, a * a + c * c, a * a + b * b))
        xyz, rpy = rng.uniform(-0.4, 0.4, 3), rng.uniform(-2, 2, 3)
        axis = joint.get("axis", rng.normal(size=3))
        axis = np.asarray(axis) / np.linalg.norm(axis)
        text = lambda v: " ".join(f"{x:.17g}" for x in v)  # noqa: E731
        parts.append(
            f'<link name="l{i}"><inertial><origin xyz="{text(com)}" rpy="0.3 -0.2 0.7"/>'
            f'<mass value="{mass:.17g}"/><inertia ixx="{ixx:.17g}" iyy="{iyy:.17g}" '
            f'izz="{izz:.17g}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="j{i}" type="{joint.get("type", "revolute")}">'
            f'<parent link="l{joint.get("parent", i - 1)}"/><child link="l{i}"/>'
            f'<origin xyz="{text(xyz)}" rpy="{text(rpy)}"/><axis xyz="{text(axis)}"/>'
            '<limit lower="-3" upper="3" effort="100" velocity="5"/></joint>'
        )
    return "".join([*parts, "</robot>"])


SERIAL = urdf([{} for _ in range(5)])
PRISMATIC = urdf([{}, {"type": "prismatic"}, {}, {"type": "prismatic"}], seed=1)
BRANCHED = urdf([{}, {}, {"parent": 1}, {"parent": 3}, {"parent": 2, "type": "prismatic"}], seed=2)
ALL = {"serial": SERIAL, "prismatic": PRISMATIC, "branched": BRANCHED}
