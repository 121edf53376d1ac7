"""Joints that turn twice: nobody is sent to the other one of two poses that weigh alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.dynamics import robot_from_profile
from pa10d.profile import load_profile
from pa10d.trajectory.excitation.problem import ExcitationProblem
from pa10d.trajectory.limits import POSITION_MARGIN
from pa10d.trajectory.poses import Surroundings
from tests.trajectory.sample_arms import pa10

HOME = np.array([0.0, -np.pi / 2, 0.0, 0.0, 0.0, 0.0])


def twice_round():
    """As the maker's file of a UR has it: its upper arm would come to the other side of ±π through
    the floor."""
    wide = np.full(6, 2 * np.pi)
    arm = replace(robot_from_profile(load_profile("ur5e")), lower=-wide, upper=wide, home=HOME)
    slides = arm.prismatic.copy()
    slides[5] = True
    return arm, replace(arm, prismatic=slides)


def test_poses_are_chosen_within_half_a_turn_of_the_rest_pose():
    arm, sliding = twice_round()
    for room in (Surroundings.of(arm).room, ExcitationProblem.of(arm).room):
        np.testing.assert_allclose(room.lower, HOME - np.pi)
        np.testing.assert_allclose(room.upper, HOME + np.pi)
    around = Surroundings.of(arm)
    rng = np.random.default_rng(3)
    drawn = np.array([around.random_pose(rng) for _ in range(20)])
    assert np.abs(drawn - HOME).max() < np.pi
    assert Surroundings.of(sliding).room.upper[5] == 2 * np.pi - POSITION_MARGIN


def test_who_asks_for_a_pose_beyond_that_gets_it():
    around = Surroundings.of(twice_round()[0])
    asked = HOME + np.array([4.0, 0, 0, 0, 0, 0])
    assert around.within(asked, "pose") is asked
    assert around.allowed(asked[None])[0]


def test_arms_that_turn_less_use_all_they_have():
    around = Surroundings.of(pa10())
    assert around.room.upper[4] > 4.4
    np.testing.assert_array_equal(around.room.lower, around.limits.lower)
