"""The sign of a torque, by what a closed brake gives way to it."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.control.faults import LoopFault
from pa10d.control.in_brake import InBrake

COUNT, LIMIT = 2e-5, 10.0  # rad, N·m
REST = 20  # cycles
NOW = np.zeros(2, dtype=np.int64)
TORQUE = np.array([0.0, 2.0])
CLOSED, OPEN = np.array([True, True]), np.array([True, False])


def looks(ways, closed=CLOSED, torque=TORQUE, watch=None, rest=0.0):
    """Whether joint 2 is to be looked at once more, of rad that it and joint 1 went in each cycle
    since it was told; before that they stand, give or take ``rest`` rad."""
    watch = watch or InBrake(np.full(2, LIMIT))
    for k in range(REST):
        watch.see(np.round([0.0, rest * (-1.0) ** k] / np.array(COUNT)) * COUNT, NOW)
        assert not watch.goes_against(None, torque, NOW, CLOSED)
    found = []
    for way in ways:
        watch.see(np.round(np.broadcast_to(way, 2)[::-1] / COUNT) * COUNT, NOW)
        found.append(watch.goes_against(1, torque, NOW, closed))
    return found


def gives(way, other=0.0):
    """Both joints' way within four cycles, as a brake gives."""
    return [(way * share, other * share) for share in (0.0, 0.6, 1.02, 0.99, 1.0, 1.0)]


def test_a_joint_that_goes_against_its_torque_in_its_brake_is_looked_at_again_and_told():
    watch = InBrake(np.full(2, LIMIT))
    assert any(looks(gives(-1e-3), watch=watch))
    with pytest.raises(
        LoopFault, match=r"2 N·m in its closed brake and went the other way"
    ) as told:
        looks(gives(-1e-3), watch=watch)
    assert (told.value.kind, told.value.axis) == ("wrong_sign", 1)


def test_a_drive_that_finds_its_phases_once_is_none_that_is_turned_round():
    watch = InBrake(np.full(2, LIMIT))
    assert any(looks(gives(-1e-3), watch=watch))
    assert not any(looks(gives(1e-3), watch=watch))
    assert not any(looks(gives(0.0), watch=watch))


@pytest.mark.parametrize(
    ("ways", "more"),
    [
        (gives(1e-3), {}),
        (gives(-2.1 * COUNT), {}),  # of its encoder
        (gives(-1e-3), {"rest": 2e-4}),  # it swings in its brake
        (gives(-1e-3, other=-5e-4), {}),  # the arm is shaken
        (gives(-1e-3), {"closed": OPEN}),  # it falls
        (gives(-1e-3), {"torque": np.array([0.0, 0.1])}),  # friction holds as much
    ],
)
def test_what_says_nothing_of_a_sign(ways, more):
    assert not any(looks(ways, **more))


def test_little_that_goes_against_it_is_remembered_and_not_told():
    watch = InBrake(np.full(2, LIMIT))
    assert not any(looks(gives(-2.1 * COUNT), watch=watch))
    assert watch.leaning == {1}
    watch.restart()
    assert not any(looks(gives(-1.1 * COUNT), watch=watch))
    assert not watch.leaning
