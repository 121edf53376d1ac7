"""Simulated time stands still while the arm does not answer, and not for ever."""

from __future__ import annotations

import numpy as np
import pytest


def test_an_arm_that_stood_still_for_long_is_told_as_silent(make_world):
    """It wakes a little later and works off what waited for it, the answers a batch: that is not
    told as a joint that is too fast."""
    world = make_world(simulation={"clock": "simulated"})

    def story():
        yield from world.moving()
        world.stall("arm", 8.3)
        yield world.is_in("fault")

    world.run(story())
    fault = world.faults[0]
    assert (fault.kind, fault.axis) == ("silent", None)
    assert "no drive has sent a TPDO for 8 s" in fault.sentence
    assert np.abs(world.drives.mechanics.velocity).max() < 1e-2


@pytest.mark.by_default("2")
@pytest.mark.parametrize("at_once", [2, 5, 40])
def test_nor_are_answers_that_come_in_several_batches(make_world, at_once):
    """Its ramp was told as getting faster: several of its periods were seen as one."""
    world = make_world(simulation={"clock": "simulated"})

    def story():
        yield from world.moving()
        world.stall("arm", 9.0)
        world.at_once = at_once
        yield world.is_in("fault")

    world.run(story())
    assert [fault.kind for fault in world.faults] == ["silent"]
    assert "got faster" not in world.faults[-1].sentence


def test_one_that_its_drive_does_drive_on_is_told(make_world):
    """However its answers come."""
    world = make_world(simulation={"clock": "simulated"})

    def story():
        yield from world.moving()
        world.stall("arm", 9.0)
        world.at_once = 5
        world.drives.mechanics.motors = np.array([-1.0, 1.0, 1.0])
        yield world.is_in("fault")

    world.run(story())
    assert "joint 1 got faster" in world.faults[-1].sentence
    assert "joint 2" not in world.faults[-1].sentence
