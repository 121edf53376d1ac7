"""Drives whose node ids are mixed up are told by what the joints weigh, and no rough URDF is."""

from __future__ import annotations

import numpy as np
import pytest
from test_mounting import moved, rubs

from pa10d.control.joint_figures import ROUGH, presumed_figures
from pa10d.dynamics import robot_from_profile
from pa10d.experiments.exchanged import alike, exchanged_drives
from pa10d.profile import load_profile

DOWN = np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def robot():
    return robot_from_profile(load_profile("pa10-sim"))


def said(robot, seed, pair=None, sways=None):
    """Of an arm with bodies up to three times off, whose drives of ``pair`` are exchanged; one
    joint ``sways``, by a twentieth of what its motor gives."""
    off = np.exp(np.random.default_rng(seed).uniform(-np.log(ROUGH), np.log(ROUGH), robot.n))
    ((q, torque, rate),), order = moved(robot, off, DOWN, seed), np.arange(robot.n)
    if pair is not None:
        order[list(pair)] = order[list(reversed(pair))]
    coulomb = rubs(robot)[order]
    if sways is not None:
        sway = 0.05 * robot.effort[sways] * np.sin(2 * np.pi * 0.4 * np.arange(len(q)) / rate)
        torque = torque + np.where(np.arange(robot.n) == sways, sway[:, None], 0.0)
        coulomb[sways] = 0.0  # of one that sways no friction is seen
    known = presumed_figures(robot).but(coulomb=coulomb, rotor=np.zeros(robot.n))
    pairs = [(i, j) for j in range(robot.n) for i in range(j)]
    return exchanged_drives(robot, known, [(q[:, order], torque[:, order], rate)], pairs)


@pytest.mark.parametrize("pair", [(1, 2), (1, 3), (3, 5)])
def test_exchanged_drives_are_named(robot, pair):
    assert f"joints {pair[0] + 1} and {pair[1] + 1} are exchanged" in said(robot, 1, pair)


@pytest.mark.by_default("0")
@pytest.mark.parametrize("seed", range(4))
def test_a_rough_urdf_exchanges_none(robot, seed):
    assert said(robot, seed) is None


@pytest.mark.by_default("1")
@pytest.mark.parametrize("seed", [1, 2, 3, 5])
def test_what_sways_by_a_weak_motor_is_not_explained_by_a_strong_one(robot, seed):
    """Of which a thousandth is as much as all of that: errors go along with their drives."""
    for joint in (4, 5, 6):
        assert said(robot, seed, sways=joint) is None


def test_drives_that_count_otherwise_are_told_apart_before():
    profile = load_profile("pa10-sim")
    drives = [one.model_copy(update={"gear_ratio": one.gear_ratio + j // 2})
              for j, one in enumerate(profile.drives)]  # fmt: skip
    equal = alike(profile.model_copy(update={"drives": drives}))
    assert all(j // 2 == i // 2 for i, j in equal)
