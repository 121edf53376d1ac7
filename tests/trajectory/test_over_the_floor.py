"""An arm that may turn anywhere over a floor: random motions end deep in it, and penalties do not
lead out, for each way out of one touch is barred by another."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pa10d.dynamics import Robot, robot_from_urdf
from pa10d.trajectory.check import check
from pa10d.trajectory.excitation import search
from pa10d.trajectory.excitation.problem import ExcitationProblem
from pa10d.trajectory.kinds.excitation import Excitation
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.poses import Surroundings

JOINT = (
    '<joint name="j{j}" type="revolute"><parent link="{parent}"/><child link="l{j}"/>'
    '<origin xyz="0 0 {height}"/><axis xyz="0 1 0"/>'
    '<limit lower="-3.1" upper="3.1" effort="150" velocity="2"/></joint>'
    '<link name="l{j}"><inertial><mass value="4"/><origin xyz="0.02 0 0.2"/>'
    '<inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.005"/></inertial></link>'
)
WIDE = 1.0  # rad
SLOWLY = {"fundamental": 0.025, "harmonics": 3}


@cache
def in_a_plane(joints: int) -> Robot:
    """Links of 0.4 m one after the other, the first joint 0.1 m over the floor."""
    rows = [
        JOINT.format(j=j, parent=f"l{j - 1}" if j else "base", height=0.4 if j else 0.1)
        for j in range(joints)
    ]
    return robot_from_urdf(f'<robot name="flat"><link name="base"/>{"".join(rows)}</robot>')


@pytest.mark.parametrize(("joints", "seed"), [(2, 0), (4, 2)])
def test_a_random_series_that_would_end_in_it_is_begun_in_the_open(joints, seed):
    robot = in_a_plane(joints)
    plan = Excitation(cycles=1, seed=seed, **SLOWLY).build(Surroundings.of(robot))
    assert not [one.sentence for one in check(plan, robot, limits_of(robot))]
    assert (np.ptp(plan.sample(10.0).q, axis=0) > WIDE).all(), "it is no small motion either"


def test_a_search_all_of_whose_first_motions_end_in_it_finds_one(monkeypatch):
    monkeypatch.setattr(search, "POPULATION", 2)
    robot = in_a_plane(2)
    around = Surroundings.of(robot)
    home = tuple(around.limits.rest_pose())
    problem = ExcitationProblem(robot, (0, 1), home, around.room, 0.025, 3)
    assert problem.excess(search.search(problem, 0, seed=1, refined=0).x) == 0.0
