"""A drive that comes back with another position: nothing moves before somebody has looked."""

from __future__ import annotations

import math

import pytest

from backends.virtual.drives.injection import Injection

AWAY = 2.0  # rad by which an encoder that lost its zero reads beside


def counts(world, joint: int, angle: float) -> int:
    drive = world.drives.drives[joint - 1]
    return round(angle * drive.scaling.sign * drive.scaling.counts_per_radian)


def loses_its_zero(world, joint: int, angle: float = AWAY) -> None:
    """Its supply goes for a moment, and with it the turns that its encoder had counted."""
    drive = world.drives.drives[joint - 1]
    drive.node.injector.counts += counts(world, joint, angle)
    drive._inject(Injection.REBOOT, 0)


def unpowered(world):
    world.say("connect")
    yield world.is_in("inactive")
    world.say("enable")
    yield world.is_in("holding")
    world.say("disable")
    yield world.is_in("inactive")


def back_after_reset(world):
    yield world.is_in("fault")
    world.say("reset")
    yield world.is_in("inactive", "holding")


def last_answer(world) -> dict:
    return [told for told in world.heard() if "reply" in told][-1]


@pytest.mark.by_default("real")
@pytest.mark.parametrize("clock", ["real", "simulated"])
def test_a_joint_that_reads_elsewhere_after_a_reset_is_not_powered(make_world, clock):
    world = make_world(simulation={"clock": clock})
    answers = []

    def story():
        yield from unpowered(world)
        loses_its_zero(world, 3)
        world.say("look")
        yield from back_after_reset(world)
        world.say("enable")
        yield world.passes(1.0)
        answers.append(last_answer(world))
        assert world.state() == "inactive", world.how_it_is()
        world.say("confirm")
        yield world.passes(0.1)
        world.say("enable")
        yield world.is_in("holding")

    world.run(story())
    assert answers[0]["command"] == "enable"
    said = answers[0]["detail"]
    assert said.startswith("enable: joint 3 stood at 0.0000 and reads 2.0000 now"), said
    assert "zero_offset" in said
    assert "confirm" in said
    assert math.isclose(world.arm.path.q[2], AWAY, abs_tol=0.01)


def test_what_is_moved_by_hand_while_it_is_heard_is_believed(world):
    """Without power, brakes released: the encoder tells all of the way."""

    def story():
        yield from unpowered(world)
        drive = world.drives.drives[2]
        for _ in range(200):
            drive.node.injector.counts += counts(world, 3, 0.002)
            yield world.passes(0.004)
        world.say("enable")
        yield world.is_in("holding")

    world.run(story())
    assert world.arm.path.q[2] == pytest.approx(0.4, abs=0.01)


@pytest.mark.long
def test_a_zero_that_is_back_needs_no_word(world):
    """The drive was homed: it reads again what it read before."""

    def story():
        yield from unpowered(world)
        loses_its_zero(world, 3)
        yield from back_after_reset(world)
        assert [one.axis for one in world.arm.whereabouts.misplaced] == [2]
        world.drives.drives[2].node.injector.counts = 0
        yield world.is_in("fault")  # the counter jumps once more
        world.say("reset")
        yield world.is_in("inactive")
        world.say("enable")
        yield world.is_in("holding")

    world.run(story())


@pytest.mark.long
def test_a_reset_that_changes_nothing_needs_no_word(world):
    def story():
        yield from world.moving()
        world.drives.drives[2]._inject(Injection.FAULT, 0x4210)
        yield world.is_in("fault")
        yield world.passes(1.0)
        world.say("reset")
        yield world.is_in("inactive")
        world.say("enable")
        yield world.is_in("holding")

    world.run(story())


@pytest.mark.by_default("0.8-True", "None-False")
@pytest.mark.parametrize(("stood", "refused"), [(0.8, True), (0.003, False), (None, False)])
def test_the_next_control_process_knows_where_the_arm_stood(world, stood, refused):
    """As the daemon kept it, on disk where it ended itself."""

    def story():
        kept = None if stood is None else [0.0, 0.0, stood]
        world.say("connect", stood=kept)
        yield world.is_in("inactive")
        world.say("enable")
        yield world.passes(1.0)
        assert world.state() == ("inactive" if refused else "holding"), world.how_it_is()

    world.run(story())


def test_a_drive_that_lost_its_power_in_motion_may_have_run_on(world):
    def story():
        yield from world.moving()
        speed = float(world.drives.mechanics.velocity[2])
        way = abs(speed) * 0.5
        loses_its_zero(world, 3, way if speed > 0 else -way)
        yield world.is_in("fault")
        yield world.passes(1.0)
        world.say("reset")
        yield world.is_in("inactive")
        assert not world.arm.whereabouts.misplaced

    world.run(story())
