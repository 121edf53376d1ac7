"""Processes that get no processor for a while: an arm may stop for it, it may not run away."""

from __future__ import annotations

import random

import numpy as np
import pytest
from how_often import how_often

STALL, CALM = 0.15, 0.3  # s: means of how long a process stands still, and goes on
FARTHEST = 2.0
"""rad, of a motion that reaches 0.52 rad to either side of zero. Where the loop stands still,
drives hold the last torque until they have missed SYNC for 0.2 s, and then brake by themselves.
They let no joint go faster than 1.5 times its limit meanwhile: of joints 1 and 2 (1 rad/s,
3 rad/s²) that is 0.3 rad and 0.4 rad to brake."""


def pytest_generate_tests(metafunc):
    if "seed" in metafunc.fixturenames:
        count = how_often(metafunc.config, 3, 100)
        metafunc.parametrize("seed", range(count))


def starved(world, rng):
    """Control and arm stand still by turns, as on a machine with other things to do."""
    yield from world.moving()
    until = world.now + 4.0
    while world.now < until and world.state() == "running":
        world.stall(rng.choice(["control", "arm"]), min(rng.expovariate(1 / STALL), 1.0))
        yield world.passes(rng.expovariate(1 / CALM))
    world.say("stop")
    yield world.is_in("holding", "inactive", "fault")
    if world.state() == "holding":
        world.say("disable")
        yield world.is_in("inactive", "fault")
    yield world.passes(0.5)


@pytest.mark.by_default("2")
def test_a_starved_arm_does_not_run_away(world, seed):
    world.run(starved(world, random.Random(seed)))
    print(
        "FARTHEST",
        seed,
        round(world.farthest, 3),
        round(world.fastest, 2),
        [f.kind for f in world.faults],
    )
    assert world.farthest < FARTHEST
    assert world.rests_within(1.0) < 1.0
    stopped = world.drives.mechanics.q.copy()
    world.advance(world.now + 1.0)
    assert np.abs(world.drives.mechanics.q - stopped).max() < 0.01


def test_a_starved_loop_says_so(world):
    """Stalls until something gives: whatever that is, it is not blamed on a collision."""

    def story():
        yield from world.moving()
        while world.state() == "running":
            world.stall("control", 0.25)
            yield world.passes(0.3)
        yield world.is_in("fault")

    world.run(story())
    fault = world.faults[0]
    assert fault.kind == "starved", fault
    assert "this machine does not keep" in fault.sentence
    assert "collision" not in fault.sentence
