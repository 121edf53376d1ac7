"""An arm that goes on falling has each brake opened alone first: what falls, falls alone."""

from __future__ import annotations

import numpy as np
import pytest

from backends.canopen_cia402.brakes import CLOSES_IN
from backends.canopen_cia402.sequence import GIVES, RESTS, SWAYS, EnableOneByOne
from backends.cia402 import Control
from backends.protocol import BackendFault, Feedback
from pa10d.control.arm import ALONE_AFTER
from pa10d.control.arm import RESTS as RESTS_AFTER_A_FALL
from pa10d.control.faults import Fault, LoopFault
from pa10d.control.gains import first_gains
from pa10d.control.states import EACH
from pa10d.control.torque_exit import STANDING
from pa10d.control.trials import TRIALS


def opens_alone(arm, monkeypatch) -> list[bool]:
    """Grows by each enabling: does each brake open alone in it?"""
    alone: list[bool] = []
    for name, one_by_one in (("begin_enable", False), ("begin_enable_one_by_one", True)):
        begin = getattr(arm.backend, name)
        monkeypatch.setattr(
            arm.backend, name, lambda how=one_by_one, begin=begin: (alone.append(how), begin())
        )
    return alone


@pytest.mark.long
@pytest.mark.parametrize(("weighed", "falls"), [(2, ALONE_AFTER), (0, 1)])
def test_after_some_falls_each_brake_opens_alone_before_all_do(world, weighed, falls):
    """Or after one that told nothing: several joints fell at once."""
    open_now, when = [], []

    def until_held(seconds):
        begun = world.now
        while world.state() != "holding":
            brakes = [not drive.brake_closed for drive in world.drives.drives]
            if not open_now or open_now[-1] != brakes:
                open_now.append(brakes)
                when.append(world.now)
            assert world.now - begun < seconds, world.how_it_is()
            yield world.passes(1e-3)

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        for _ in range(falls):
            world.arm._latch(Fault("not_held", "it fell", 1, weighed=weighed), RuntimeError())
            assert world.arm.fault.alone_next == (not weighed)
            world.arm._rests = 0.1
            world.say("reset")
            yield world.is_in("inactive")
            yield world.passes(0.1)
        world.say("enable")
        yield from until_held(20.0)

    world.run(story())
    n = world.robot.n
    closed = n * [False]
    alone = [state for k in range(n) for state in ([j == k for j in range(n)], closed)]
    assert open_now[: 2 * n + 2] == [closed, *alone, n * [True]]
    assert np.diff(when[1 : 2 * n + 1]).min() > 0.1


def test_brakes_that_hang_on_one_output_open_together_from_then_on(make_world, monkeypatch):
    """However often it falls, until the arm is connected anew. Links that swing on behind the
    brakes that caught it are waited for, as after any fall."""
    world = make_world(home=[0.0, 0.9, 0.9])
    drives, faults, rested = world.drives.drives, [], []
    closed = type(drives[0]).brake_closed.fget
    together = property(lambda drive: all(closed(each) for each in drives))
    monkeypatch.setattr(type(drives[0]), "brake_closed", together)
    alone = opens_alone(world.arm, monkeypatch)

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        for _ in range(3):
            world.arm._falls = ALONE_AFTER
            world.say("enable")
            yield world.is_in("enabling")
            yield world.is_in("fault", "holding")
            if world.arm.fault is not None:
                faults.append(world.arm.fault.kind)
            began = world.now
            world.say("disable" if world.state() == "holding" else "reset")
            yield world.is_in("disabling", "resetting")
            yield world.is_in("inactive")
            rested.append(world.now - began)
        world.say("disconnect")
        yield world.is_in("offline")
        world.say("connect")
        yield world.is_in("inactive")
        assert world.arm._each_alone, "somebody may have rewired them"

    world.run(story())
    assert faults == ["brake_gave"]
    assert alone == [True, False, False]
    assert rested[0] > RESTS_AFTER_A_FALL - 1.0


class Axes:
    """Drives that do at once what they are told."""

    def __init__(self, n):
        self.n, self.words = n, []

    def set_words(self, words):
        self.words = [int(word) for word in words]


def opened(braked, moves=lambda time, words: 0.0, seconds=20.0):
    """Which drives were to be enabled, one entry for each change. moves: rad by which joint 1 is
    away from its place."""
    n, states, told = len(braked), [0x21] * len(braked), []
    axes = Axes(n)
    enabling = EnableOneByOne(axes, braked)
    for k in range(int(seconds / 0.01)):
        q = np.zeros(n)
        q[0] = moves(0.01 * k, axes.words)
        seen = Feedback(0.01 * k, q, np.zeros(n), np.array(states), np.zeros(n, np.int64))
        if not enabling.step(seen):
            return told
        states = [{0x06: 0x21, 0x07: 0x23, 0x0F: 0x27}[word] for word in axes.words]
        on = [j for j, word in enumerate(axes.words) if word == 0x0F]
        if (on or told) and told[-1:] != [on]:
            told.append(on)
    raise AssertionError("for ever")


def test_each_alone_then_all_and_what_has_no_brake_is_held_meanwhile():
    assert opened([True, True, True]) == [[0], [], [1], [], [2], [], [0, 1, 2]]
    assert opened([True, False, True]) == [[1], [0, 1], [1], [1, 2], [1], [0, 1, 2]]


def test_whoever_waits_for_it_waits_as_long_as_it_may_take():
    """Once to open, once to close, and to be seen resting after both; and falls that are stopped
    before, in half a second each."""
    slowest = SWAYS + 2.0 * RESTS + 2.0 * CLOSES_IN + 0.5 * TRIALS
    assert slowest < EACH


def test_one_that_sways_holds_up_no_other_for_ever():
    def sways(time, words):
        return 0.01 * np.sin(20 * time) * (words[:1] == [0x0F])

    assert opened([True, True], sways) == [[0], [], [1], [], [0, 1]]


def test_a_joint_that_falls_is_stopped_by_its_drive_and_tried_once_more():
    """Its brake closes as it stands, and no earlier; then others have their turn."""
    axes, states, q = Axes(2), [0x21, 0x21], np.zeros(2)
    enabling, words, stopping = EnableOneByOne(axes, [True, True]), [], 0
    for k in range(300):
        if not enabling.step(Feedback(0.01 * k, q.copy(), q, np.array(states), np.zeros(2, int))):
            break
        if k == 40:
            assert enabling.out == (0,)
            enabling.again()
        word = axes.words[0]
        if not words or words[-1] != word:
            words.append(word)
        if word == Control.QUICK_STOP and stopping < 10:
            stopping += 1
            q[0] += 0.01  # far beyond what a joint may give in its brake
        leads = {0x06: 0x21, 0x07: 0x23, 0x0F: 0x27, 0x02: 0x07, 0x00: 0x40}
        states = [leads[word] for word in axes.words]
    enable, again = Control.ENABLE, [Control.QUICK_STOP, Control.DISABLE_VOLTAGE]
    way = [Control.SHUTDOWN, Control.SWITCH_ON]
    assert words == [way[1], enable, *again, *way, enable, way[1], enable]
    assert stopping == 10


def test_a_brake_that_opens_with_anothers_is_named_before_its_joint_has_gone_far():
    went = []

    def falls(time, words):
        went.append((went[-1] if went else 0.0) + 0.005 * (words[1:] == [0x0F]))
        return went[-1]

    with pytest.raises(BackendFault, match="joint 1: left its place in its brake as that of joint"):
        opened([True, True], falls)
    assert went[-1] < GIVES + 0.01


def test_an_arm_that_nobody_has_measured_opens_each_brake_alone_at_first(make_world, monkeypatch):
    """What is thought to hold it is a URDF's word. Not where it was held before; of an arm that
    fell the falls decide, and of one that was weighed nothing is doubted."""
    world = make_world()
    arm, alone = world.arm, opens_alone(world.arm, monkeypatch)
    first = first_gains(world.robot, world.profile.control, arm.path.limits.following_error)

    def enabled():
        world.say("enable")
        yield world.is_in("holding")
        world.say("disable")
        yield world.is_in("inactive")

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        yield from enabled()
        arm._held_by = None
        world.say("gains", gains=first.document(), bodies=None)
        yield from enabled()
        yield from enabled()
        arm._held_by, arm._falls = None, 1
        yield from enabled()
        arm._held_by, arm._falls = None, 0
        world.say("gains", gains=first.document(), bodies=world.robot.parameters.tolist())
        yield from enabled()

    world.run(story())
    assert not world.faults
    assert alone == [False, True, False, False, False]


@pytest.mark.parametrize("fell", [1, 2])
def test_it_goes_on_doing_so_after_falls_until_it_was_held(make_world, monkeypatch, fell):
    """Of a URDF that is wrong about several joints each tells its own weight, with the others in
    their brakes."""
    world = make_world()
    arm, alone = world.arm, opens_alone(world.arm, monkeypatch)
    arm._rests = 0.1
    first = first_gains(world.robot, world.profile.control, arm.path.limits.following_error)

    def fall():
        error = LoopFault("not_held", "it fell", 1)
        error.weighed = 2
        arm._on_fault(error)
        yield world.is_in("fault")
        world.say("reset")
        yield world.is_in("inactive")

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        world.say("gains", gains=first.document(), bodies=None)
        for _ in range(fell):
            world.say("enable")
            yield world.is_in("enabling")
            yield world.passes(0.5)
            yield from fall()
        world.say("enable")
        yield world.is_in("holding")
        yield from fall()
        arm._falls = 1
        world.say("enable")
        yield world.is_in("holding")

    world.run(story())
    assert alone == [*(fell + 1) * [True], False]


def test_a_first_try_of_each_alone_that_tells_nothing_is_not_the_last(world):
    arm = world.arm
    arm._weighs_anew = True
    assert arm._each_alone
    for again in (True, False):
        arm.fault = None
        arm._latch(Fault("not_held", "it fell", 1), RuntimeError())
        assert arm.fault.alone_next == again


@pytest.mark.long
@pytest.mark.parametrize("believed", [0.4, 2.0])
def test_a_joint_is_weighed_before_it_falls(make_world, believed):
    """Short trials that its brake ends, in place of falls that are faults; what its URDF says of it
    is wrong by so much."""
    home = [0.0, 0.9, 0.9]
    world = make_world(home=home)
    arm = world.arm
    first = first_gains(world.robot, world.profile.control, arm.path.limits.following_error)
    tried = []

    def story():
        world.say("connect")
        yield world.is_in("inactive")
        world.say("gains", gains=first.document(), bodies=None)
        yield world.passes(0.1)
        described, again = arm._gravity, arm.backend.try_again
        arm._gravity = lambda q: believed * described(q)
        arm.backend.try_again = lambda: (tried.append(arm.path.holding.alone), again())
        world.say("enable")
        yield world.is_in("enabling")
        yield world.is_in("holding", "fault")
        world.say("disable")
        yield world.is_in("inactive", "fault")

    world.run(story())
    assert not world.faults
    assert tried
    assert max(tried.count(joint) for joint in tried) <= TRIALS
    way = np.maximum(world.highest - home, home - world.lowest)
    assert way.max() < 0.1
    assert world.fastest < STANDING * arm.path.limits.velocity.max()
