"""A base that is tilted and nobody said so: gravity's direction is named, once for the robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from one_ur5e import recorded, ur5e

from pa10d.checks.gravity import check_gravity


@pytest.fixture(scope="module")
def robot():
    return ur5e()


@pytest.fixture(scope="module")
def level():
    return recorded(20.0)


def tilted(robot, degrees, axis):
    """The robot as a profile has it whose base stands otherwise than the arm that was recorded."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array(
        [[1, 0, 0], [0, c, -s], [0, s, c]] if axis == 0 else [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    )
    return robot.with_gravity(turn @ robot.gravity)


def test_the_declared_direction_is_not_doubted(level, robot):
    assert list(check_gravity(level, robot)) == []


@pytest.mark.parametrize(("degrees", "axis"), [(20.0, 0), (-20.0, 1)])
def test_an_undeclared_tilt_is_said_once_with_its_size(level, robot, degrees, axis):
    (found,) = check_gravity(level, tilted(robot, degrees, axis))
    assert found.code == "gravity"
    assert found.joint is None
    told = float(found.sentence.split("from ")[1].split("°")[0])
    assert told == pytest.approx(20.0, abs=4.0)
    assert "profile" in found.advice


def test_one_joint_alone_does_not_doubt_gravity(level, robot):
    """A spring on one joint is no tilt, whatever direction would explain most of it."""
    tau = level.tau.copy()
    tau[:, 1] += 25.0 * np.sin(level.q[:, 1] + 0.7) ** 3
    assert list(check_gravity(replace(level, tau=tau), robot)) == []


def test_a_weightless_robot_has_no_direction(level, robot):
    assert list(check_gravity(level, robot.with_gravity(np.zeros(3)))) == []
