"""Effects of a slide that carries its own weight: metres are not radians."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from two_links import RATE, SECONDS

from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import Robot, inverse_dynamics, robot_from_urdf
from pa10d.effects.base import smooth_sign
from pa10d.effects.registry import effect
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording

URDF = """<robot name="lift"><link name="base"/>
<joint name="a" type="prismatic"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="500" velocity="3"/></joint>
<link name="l1"><inertial><mass value="6"/><origin xyz="0 0 0"/>
<inertia ixx="0.1" iyy="0.1" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="b" type="revolute"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l2"><inertial><mass value="2"/><origin xyz="0.02 0 0.15"/>
<inertia ixx="0.03" iyy="0.03" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


@cache
def lift() -> Robot:
    return robot_from_urdf(URDF)


def recorded(name: str, seed: int, extra) -> Recording:
    """The slide moves within ±0.1 m. extra(q, dq) -> (N,) N more on it."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(SECONDS * RATE)) / RATE
    w = 2 * np.pi * rng.uniform(0.08, 0.7, (6, 2))
    a = np.array([0.025, 0.4]) * rng.uniform(0.5, 1.0, (6, 2))
    angle = w * t[:, None, None] + rng.uniform(0, 2 * np.pi, (6, 2))
    q, dq = (a * np.sin(angle)).sum(1), (a * w * np.cos(angle)).sum(1)
    ddq = -(a * w**2 * np.sin(angle)).sum(1)
    tau = inverse_dynamics(lift(), lift().parameters, q, dq, ddq)
    sign = np.column_stack([smooth_sign(dq[:, 0], 0.001), smooth_sign(dq[:, 1], 0.01)])
    tau += np.array([7.0, 0.5]) * sign + np.array([20.0, 0.3]) * dq
    tau[:, 0] += extra(q[:, 0], dq[:, 0])
    return Recording(name, t, q, tau + np.array([0.15, 0.02]) * rng.standard_normal(q.shape))


def spring(q, dq):
    return 60.0 * (q - 0.05)


def tight_spot(q, dq):
    return 3.0 * np.exp(-0.5 * ((q + 0.03) / 0.015) ** 2) * smooth_sign(dq, 0.001)


@pytest.mark.long
@pytest.mark.parametrize(
    ("extra", "expected", "parameters"),
    [
        (spring, "spring", {"k": 60.0}),
        pytest.param(
            tight_spot,
            "position_friction",
            {"A": 3.0, "qc": -0.03, "w": 0.015},
            marks=pytest.mark.long,
        ),
    ],
)
def test_an_effect_of_a_slide_is_named_with_its_size(extra, expected, parameters):
    runs = [recorded(name, seed, extra) for seed, name in enumerate(("a", "b", "judge"))]
    found = diagnose(identify(runs[:2], lift(), name="m0"), runs[:2], runs[2:])
    (only,) = found.findings
    assert (only.term.effect_id, only.term.joints) == (expected, (0,))
    for name, truth in parameters.items():
        told = only.parameters[name]
        assert told.determined
        assert abs(told.value - truth) < 0.05 * abs(truth)
    if expected == "spring":
        assert not only.parameters["q0"].determined, "its constant part is the weight's, too"


@pytest.mark.parametrize(("axis", "never"), [("0 0 1", {"q0"}), ("1 0 0", set())])
def test_where_a_spring_of_a_slide_pulls_to_is_shown_by_no_motion_beside_its_weight(axis, never):
    """A lift bears it, whatever it carries does; a slide on the level bears none."""
    arm = robot_from_urdf(URDF.replace("0 0 1", axis))
    assert effect("spring").never_shown(arm, (0,)) == never
    assert not effect("spring").never_shown(arm, (1,))
