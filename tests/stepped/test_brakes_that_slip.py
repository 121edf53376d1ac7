"""A brake that does not hold what hangs on it is told, and the arm is held at once when asked."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.control.faults import Fault, LoopFault
from pa10d.control.limits import ArmLimits
from pa10d.control.slipping import CATCHES, Slipping

FINE = Fault("", "")
WEAK = 0.85  # of what it needs; friction bears a little, too
AT = 1  # 0-based, of the joint


def swinging(world):
    yield from world.moving()


def held(world):
    world.say("connect")
    yield world.is_in("inactive")
    world.say("enable")
    yield world.is_in("holding")


@pytest.mark.parametrize(
    "before", [held, pytest.param(swinging, marks=pytest.mark.long)], ids=["held", "moving"]
)
def test_after_a_stop_by_the_drives_it_is_told_and_then_held_by_all_motors_at_once(
    make_world, before
):
    """Each brake alone, as after any such stop, it slipped on meanwhile: 1.2 rad."""
    world = make_world(home=[0.0, 0.9, 0.9])
    mechanics, stood = world.drives.mechanics, []

    def story():
        yield from before(world)
        for _ in range(2):
            world.arm.emergency("daemon_gone", "test")
        yield world.is_in("fault")
        need = abs(float(world.arm._weight(mechanics.q)[AT]))
        mechanics._brake_limit[AT] = WEAK * need
        yield lambda: f"joint {AT + 1} went 0.03" in world.arm.fault.cause
        assert "prop it up" in world.arm.fault.remedy
        world.say("reset")
        yield world.is_in("inactive")
        world.say("enable")
        stood.append(float(mechanics.q[AT]))
        yield world.is_in("holding")
        stood.append(float(mechanics.q[AT]))

    world.run(story())
    assert world.faults[0].kind == "daemon_gone"
    assert abs(stood[1] - stood[0]) < 0.02, "it was not caught at once"


def test_links_are_not_waited_for_while_a_brake_slips(make_world):
    """After a fall `reset` lasts 5 s: the joint went on falling meanwhile."""
    world = make_world(home=[0.0, 0.9, 0.9])
    mechanics, lasted = world.drives.mechanics, []

    def story():
        yield from held(world)
        mechanics._brake_limit[AT] = WEAK * abs(float(world.arm._weight(mechanics.q)[AT]))
        world.arm._on_fault(LoopFault("brake_gave", "left its place in its brake", AT))
        yield lambda: "in its closed brake" in (world.arm.fault or FINE).cause
        began = world.now
        world.say("reset")
        yield world.is_in("inactive")
        lasted.append(world.now - began)

    world.run(story())
    assert lasted[0] < 0.5


def test_switched_off_by_somebody_who_insists_it_is_a_fault_of_its_own(make_world):
    world = make_world(home=[0.0, 0.9, 0.9])

    def story():
        yield from held(world)
        need = abs(float(world.arm._weight(world.drives.mechanics.q)[AT]))
        world.drives.mechanics._brake_limit[AT] = WEAK * need
        world.say("disable", anyway=True)
        yield world.is_in("fault")

    world.run(story())
    assert [(fault.kind, fault.axis) for fault in world.faults[:1]] == [("brake_slips", AT)]
    assert "in its closed brake" in world.faults[0].cause


ONES = np.ones(2)
LIMITS = ArmLimits(-9.0 * ONES, 9.0 * ONES, ONES, ONES, ONES, ONES, 0.15 * ONES)


def told(path, seconds=4.0, period=0.01, braked=True):
    """What is said of joint 1 on this way, rad at s since its power has gone."""
    slipping, said, last = Slipping(LIMITS, 0.0, np.array([-1.0, 0.0])), [], path(0.0)
    for k in range(1, int(seconds / period)):
        now, q = k * period, path(k * period)
        if slipping.over(now):
            break
        speed = (q - last) / period
        at, fast, fresh = np.array([q, 0.0]), np.array([speed, 0.0]), np.zeros(2, np.int64)
        said += slipping.see(now, at, fast, fresh, np.full(2, braked))
        last = q
    return said


def test_a_brake_may_catch_a_joint_on_its_way_and_a_hand_may_turn_it_later():
    assert told(lambda t: 0.0) == []
    assert told(lambda t: 0.3 * min(t, 0.3)) == [], "it was fast, and came to rest"
    assert told(lambda t: 0.5 * max(t - 1.0, 0.0)) == [], "nobody knows who moves it by then"
    assert told(lambda t: -0.1 * t * t) == [], "upwards"
    assert told(lambda t: 2.0 * (t > 0.3)) == [], "its encoder jumped, or its drive began anew"
    assert told(lambda t: 0.1 * t * t, braked=False) == [], "it has none, or that opens"
    assert [axis for axis, _ in told(lambda t: 0.1 * t * t)] == [0]
    assert [axis for axis, _ in told(lambda t: 0.2 * t)] == [0], f"on its way after {CATCHES} s"
