"""Simulated time stands still while the arm does not answer, and not for ever."""

from __future__ import annotations

import numpy as np


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
