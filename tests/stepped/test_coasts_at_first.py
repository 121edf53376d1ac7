"""Until the sign of a joint is known its drive does not ramp it down at a fault of its own: no
command would end that, and a ramp drives a joint of the wrong sign on."""

from __future__ import annotations

import numpy as np
import pytest

from backends.cia402 import FaultReaction
from pa10d.control.faults import LoopFault
from pa10d.control.gains import first_gains
from pa10d.control.loop import describe
from pa10d.control.right_way import FAR, RightWay
from pa10d.control.told import ArmTold

WRONG = 1  # 0-based
COASTS, RAMPS = FaultReaction.DISABLE, FaultReaction.QUICK_STOP
OVERCURRENT = 0x2310


def reactions(world):
    """0x605E of each drive, as it would react now."""
    return [drive.machine.options.fault_reaction for drive in world.drives.drives]


def held(world, **known):
    world.say("connect", **known)
    yield world.is_in("inactive")
    world.say("enable")
    yield world.is_in("holding")


def test_a_joint_that_nobody_has_seen_move_is_left_to_its_brake(world):
    """Its drive finds something as it moves for the first time. 15 rad/s along the ramp."""
    begun, speeds = [], []

    def story():
        yield from world.moving()
        assert not world.arm.right_way.known[WRONG], "it went one way only"
        mechanics = world.drives.mechanics
        mechanics.motors = np.where(np.arange(world.robot.n) == WRONG, -1.0, 1.0)
        begun.append(abs(mechanics.velocity[WRONG]))
        world.drives.drives[WRONG].fault(OVERCURRENT)

        def ends():
            speeds.append(float(np.abs(mechanics.velocity[WRONG])))
            return world.state() == "fault"

        yield ends
        yield world.passes(0.5)

    world.run(story())
    assert begun[0] > 0.1, "it did not move: nothing was shown"
    assert max(speeds) < begun[0] + 0.05
    assert world.at_rest()


def test_a_joint_that_its_drive_stops_as_another_faults_is_left_to_its_brake(make_world):
    """Nobody looked at its ramp any more: 5.7 rad/s, and the next brakes slip by that."""
    world = make_world(home=[0.0, 0.9, 0.9])
    arm, mechanics = world.arm, world.drives.mechanics
    first = first_gains(world.robot, world.profile.control, arm.path.limits.following_error)
    seen: list[tuple[int, float]] = []

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        world.say("gains", gains=first.document(), bodies=None)
        yield world.passes(0.1)
        described, again = arm._gravity, arm.backend.try_again

        def stopped():
            falls = arm.path.brakes.stopped
            mechanics.motors = np.where(np.arange(world.robot.n) == falls, -1.0, 1.0)
            seen.append((falls, 0.0))
            again()

        arm._gravity = lambda q: 0.4 * described(q)
        arm.backend.try_again = stopped
        world.say("enable")
        yield lambda: bool(seen)
        arm._on_fault(LoopFault("brake_gave", "left its place in its brake", 2))

        def ends():
            seen.append((seen[0][0], float(np.abs(mechanics.velocity[seen[0][0]]))))
            return world.state() == "fault"

        yield ends
        yield world.passes(0.5)

    world.run(story())
    assert max(speed for _, speed in seen) < 0.5
    assert world.at_rest()


def test_one_that_its_ramp_has_not_slowed_gets_no_other(make_world, monkeypatch):
    """It was too fast at last, all drives were told to stop, and it was given the time anew in
    which a ramp begins."""
    monkeypatch.setattr("pa10d.control.trials.FOR", 10**6)  # nor is it seen otherwise
    world, speeds = make_world(home=[0.0, 0.9, 0.9]), []
    arm, mechanics = world.arm, world.drives.mechanics
    first = first_gains(world.robot, world.profile.control, arm.path.limits.following_error)

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        world.say("gains", gains=first.document(), bodies=None)
        yield world.passes(0.1)
        described, again = arm._gravity, arm.backend.try_again

        def stopped():
            falls = np.arange(world.robot.n) == arm.path.brakes.stopped
            mechanics.motors = np.where(falls, -1.0, 1.0)
            again()

        arm._gravity = lambda q: 0.4 * described(q)
        arm.backend.try_again = stopped
        world.say("enable")
        yield lambda: arm.path.brakes.stopped_in_vain is not None
        falls = arm.path.brakes.stopped_in_vain
        speeds.append(abs(mechanics.velocity[falls]))
        arm._on_fault(LoopFault("not_held", "moves by itself", falls))

        def ends():
            speeds.append(abs(mechanics.velocity[falls]))
            return world.state() == "fault"

        yield ends
        yield world.passes(0.5)

    world.run(story())
    assert max(speeds) < speeds[0] + 0.5, "5.7 rad/s before"
    assert "got faster as its own drive" in world.faults[-1].sentence
    assert world.at_rest()


def test_nor_does_one_that_leaves_its_place_as_its_brake_closes_alone(make_world):
    """It was held by friction, whatever its sign, and its drive holds it until its brake does."""
    world, speeds = make_world(home=[0.0, 0.9, 0.9]), []
    arm, mechanics = world.arm, world.drives.mechanics
    first = first_gains(world.robot, world.profile.control, arm.path.limits.following_error)

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        world.say("gains", gains=first.document(), bodies=None)
        yield world.passes(0.1)
        world.say("enable")
        yield lambda: arm.path.brakes.closing == WRONG
        mechanics.motors = np.where(np.arange(world.robot.n) == WRONG, -1.0, 1.0)

        def ends():
            speeds.append(abs(mechanics.velocity[WRONG]))
            return world.state() == "fault"

        yield ends
        yield world.passes(0.5)

    world.run(story())
    assert max(speeds) < 1.2, "2.2 rad/s before"
    assert "got faster as its own drive" in world.faults[-1].sentence
    assert world.at_rest()


def test_a_joint_that_leaves_its_place_as_its_brake_closes_is_left_to_that(make_world):
    """Friction had held it, whatever its sign; as it is switched off its drive holds it meanwhile,
    by a loop of its own: 5.8 rad/s and 0.7 rad, for nobody looked before it was too fast."""
    world, seen = make_world(home=[0.0, 0.9, 0.9]), []

    def story():
        yield from held(world)
        world.say("disable")
        yield world.is_in("disabling")
        mechanics = world.drives.mechanics
        mechanics.motors = np.where(np.arange(world.robot.n) == WRONG, -1.0, 1.0)
        at = mechanics.q[WRONG]

        def ends():
            seen.append((abs(mechanics.q[WRONG] - at), abs(mechanics.velocity[WRONG])))
            return world.state() == "fault"

        yield ends
        yield world.passes(0.5)

    world.run(story())
    way, speed = np.max(seen, axis=0)
    assert way < 0.05
    assert speed < 1.5
    assert "its power was taken away at once" in world.faults[-1].sentence
    assert world.at_rest()


def test_it_ramps_down_once_its_torque_has_shown_its_sign(world):
    n, seen = world.robot.n, []

    def story():
        yield from held(world)
        seen.append(reactions(world))
        world.swing()
        yield lambda: reactions(world) == n * [RAMPS]
        seen.append(world.arm.right_way.known.all())
        world.arm._doubt_sign(WRONG)
        yield lambda: reactions(world)[WRONG] == COASTS
        seen.append(reactions(world))

    world.run(story())
    assert seen[0] == n * [COASTS]
    assert seen[1]
    assert seen[2] == [COASTS if k == WRONG else RAMPS for k in range(n)]


def test_an_arm_that_was_measured_ramps_down_from_the_beginning(world):
    def story():
        yield from held(world, measured=True)
        assert reactions(world) == world.robot.n * [RAMPS]

    world.run(story())


@pytest.mark.parametrize(
    ("wanted", "went", "known"),
    [
        ([1, -1], [1, -1], True),
        ([1, -1], [0.7, -0.7], True),
        ([1, 0, 1, 0], [1, 0, 1, 0], True),
        ([1, 2, 3], [1, 2, 3], False),
        ([1, -1], [1, 0], False),
        ([1, -1], [0, 0], False),
        ([1, -1], [-1, 1], False),
        ([0.3, -0.3, 0.3], [0.3, -0.3, 0.3], False),
    ],
    ids=[
        "there and back", "softly", "back to where it was", "one way, as if it fell",
        "it did not come back", "friction holds it", "the other way", "hardly moved",
    ],
)  # fmt: skip
def test_it_is_known_of_who_goes_there_and_back_as_it_is_led(wanted, went, known):
    seen = RightWay(1)
    ways = [
        np.interp(np.arange(0, len(w), 0.01), range(len(w) + 1), [0, *w]) for w in (wanted, went)
    ]
    for led, is_at in np.transpose(ways) * 1.2 * FAR:
        seen.see(np.array([led]), np.array([is_at]))
    assert bool(seen.known[0]) is known


def test_what_a_fault_doubted_no_old_measurement_makes_known():
    """A new connect took it for known again."""
    seen = RightWay(2)
    seen.connected(measured=True)
    seen.doubt(WRONG)
    seen.connected(measured=True)
    assert seen.known.tolist() == [True, False]
    seen.begin(np.zeros(2))
    for q in np.concatenate([np.linspace(0.0, 2.0 * FAR, 20), np.linspace(2.0 * FAR, 0.0, 20)]):
        seen.see(np.full(2, q), np.full(2, q))
    seen.connected(measured=True)
    assert seen.known.all()


def test_the_process_that_comes_next_is_told_of_the_doubt(world):
    """An old measurement would have its drives ramp it on."""

    def story():
        yield from held(world, measured=True, doubted=[WRONG + 1])
        yield world.passes(0.5)

    world.run(story())
    assert reactions(world) == [COASTS if k == WRONG else RAMPS for k in range(world.robot.n)]
    assert describe(world.arm).doubted == (WRONG + 1,), "and tells it on"
    assert ArmTold.from_document(describe(world.arm).document()).doubted == (WRONG + 1,)
