"""Whoever ends while the arm moves, and whenever: it comes to rest, brakes on, power off."""

from __future__ import annotations

import random

import pytest
from how_often import how_often

from backends.virtual.drives.injection import Injection

REST = 2.0  # s until the arm is at rest with its brakes on
SETTLED = 0.1  # s until brakes that have just closed have swallowed what was left


def pytest_generate_tests(metafunc):
    if "moment" in metafunc.fixturenames:
        count = how_often(metafunc.config, 1, 50)
        draw = random.Random(metafunc.function.__name__)
        metafunc.parametrize("moment", [round(draw.uniform(0.0, 1.5), 3) for _ in range(count)])


def test_control_ends(world, moment):
    def story():
        yield from world.moving()
        yield world.passes(moment)
        world.kill("control")
        yield world.passes(1.0)

    world.run(story())
    assert world.rests_within(REST) < REST
    assert world.farthest < 1.5


@pytest.mark.parametrize("wait", [0.5, pytest.param(20.0, marks=pytest.mark.long)])
def test_a_reset_is_enough_after_control_was_killed(world, wait):
    """The next control process finds the drives in fault before it has measured anything."""

    def holding():
        world.say("connect")
        yield world.is_in("inactive")
        world.say("enable")
        yield world.is_in("holding")
        world.kill("control")
        yield world.passes(1.0)

    def acknowledged():
        world.say("connect")
        yield world.is_in("fault")
        world.say("reset")
        yield world.is_in("resetting")
        yield world.is_in("inactive", "fault")
        assert world.state() == "inactive", world.how_it_is()

    world.run(holding())
    world.advance(world.now + wait)
    world.start_control_again()
    world.run(acknowledged())
    assert world.at_rest()


def test_the_daemon_ends(world, moment):
    def story():
        yield from world.moving()
        yield world.passes(moment)

    world.run(story())  # a story that is over ends the daemon
    assert world.rests_within(SETTLED) < SETTLED
    assert [fault.kind for fault in world.faults] == ["daemon_gone"]
    assert world.farthest < 0.7


def test_the_daemon_hangs(world):
    def story():
        yield from world.moving()
        world.fall_silent()
        yield world.is_in("fault")

    world.run(story())
    assert world.rests_within(SETTLED) < SETTLED
    assert [fault.kind for fault in world.faults] == ["daemon_gone"]


def test_the_arm_ends(world, moment):
    def story():
        yield from world.moving()
        yield world.passes(moment)
        world.kill("arm")
        yield world.is_in("fault")

    world.run(story())
    assert [fault.kind for fault in world.faults] == ["silent"]


@pytest.mark.by_default("running")
@pytest.mark.parametrize("state", ["inactive", "holding", "running"])
def test_the_daemon_ends_in_any_state(world, state):
    def story():
        for _ in world.moving():
            yield _
            if world.state() == state:
                return

    world.run(story())
    assert world.state() == "offline"
    assert world.rests_within(REST) < REST


def test_a_signal_stops_the_arm_that_no_daemon_speaks_for(world):
    """As SIGUSR1 does; the arm is held where it has come to rest."""

    def story():
        yield from world.moving()
        world.loop.stop()
        yield world.is_in("stopping")
        yield world.is_in("holding", "fault")
        assert world.state() == "holding"

    world.run(story())
    assert world.farthest < 0.7


def test_a_reset_before_the_brakes_are_on_is_told_to_wait(world):
    """There is a fault to leave, whatever the state is called; it was said that there is none."""

    def story():
        yield from world.moving()
        world.drives.drives[2]._inject(Injection.EMCY, 0x8110)
        yield world.is_in("stopping", "disabling")
        world.say("reset")
        yield world.is_in("fault")

    world.run(story())
    (refused,) = [told for told in world.heard() if told.get("ok") is False]
    assert refused["remedy"].startswith("wait until")
