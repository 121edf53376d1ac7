"""A torque that acts the wrong way round is seen before its brake opens."""

from __future__ import annotations

import numpy as np

from pa10d.control.gains import first_gains

WRONG = 1  # 0-based


def test_the_brake_of_a_wrong_sign_stays_closed(make_world):
    """It opened, and the joint was at 1.4 rad/s as its power was cut."""
    world = make_world(home=[0.0, 0.9, 0.9])
    mechanics, arm = world.drives.mechanics, world.arm
    first = first_gains(world.robot, world.profile.control, arm.path.limits.following_error)
    far = []

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        world.say("gains", gains=first.document(), bodies=None)
        yield world.passes(0.1)
        mechanics.motors = np.where(np.arange(world.robot.n) == WRONG, -1.0, 1.0)
        began = mechanics.q.copy()
        world.say("enable")

        def ends():
            far.append(abs(float((mechanics.q - began)[WRONG])))
            return world.state() in ("fault", "holding")

        yield world.passes(0.05)
        yield ends

    world.run(story())
    assert [(fault.kind, fault.axis) for fault in world.faults] == [("wrong_sign", WRONG)]
    assert "in its closed brake" in world.faults[0].sentence
    assert max(far) < 0.006, "it came out of its brake"


def test_a_joint_that_leaned_against_its_torque_is_left_to_its_brake_as_it_falls(make_world):
    """Too little was seen to be sure. Its drive was told to stop it: 1.05 times its limit."""
    world = make_world(home=[0.0, 0.9, 0.9])
    mechanics, arm = world.drives.mechanics, world.arm
    first = first_gains(world.robot, world.profile.control, arm.path.limits.following_error)
    limit, speeds, again = arm.path.limits.velocity[WRONG], [], []

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        world.say("gains", gains=first.document(), bodies=None)
        yield world.passes(0.1)
        described = arm._gravity
        arm._gravity = lambda q: 0.4 * described(q)
        arm.backend.try_again = lambda: again.append(True)
        arm.path._in_brake._against = lambda axis, push: 0.0
        world.say("enable")
        yield world.passes(0.05)
        mechanics.motors = np.where(np.arange(world.robot.n) == WRONG, -1.0, 1.0)

        def ends():
            speeds.append(float(np.abs(mechanics.velocity[WRONG])))
            return world.state() == "fault"

        yield ends
        yield world.passes(0.5)
        world.say("reset")
        yield world.is_in("inactive")
        world.say("enable")
        yield world.passes(0.05)
        yield ends

    world.run(story())
    told = [(fault.kind, fault.axis) for fault in world.faults]
    assert told == [("not_held", WRONG), ("wrong_sign", WRONG)]
    assert "gave way against its torque in its brake" in world.faults[0].sentence
    assert not world.faults[0].weighed, "it is begun with more of it"
    assert not again
    assert max(speeds) < 0.5 * limit


def test_a_joint_that_slips_in_its_closed_brake_is_not_weighed(world):
    """What a brake takes of its load makes it look lighter than it is: it was told to have fallen,
    and what would have held it."""
    mechanics = world.drives.mechanics
    fell = np.arange(world.robot.n) == WRONG

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        strongest = world.arm.path.limits.torque
        world.arm._gravity = lambda q: np.where(fell, 0.95 * strongest, 0.0)
        mechanics._brake_limit = np.where(fell, 0.02 * strongest, mechanics._brake_limit)
        world.say("enable")
        yield world.passes(0.02)
        yield world.is_in("fault", "holding")

    world.run(story())
    assert [(fault.kind, fault.axis) for fault in world.faults[:1]] == [("brake_gave", WRONG)]
    assert world.faults[0].weighed == 0
