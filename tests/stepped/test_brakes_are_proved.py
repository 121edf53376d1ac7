"""Before power goes the brakes have the load, and power is at hand: one that does not hold is told,
and its joint held again before it has fallen."""

from __future__ import annotations

import numpy as np
import pytest
from small_arm import joints_of_the_arm

from pa10d.control.brake_proof import TAKES, BrakeProof, Unheld, why_still_powered
from pa10d.control.limits import ArmLimits

AT = 1  # 0-based, of the joint whose brake is weak
MOST = 0.02  # rad that it may go, to and fro
BEFORE = 0.25  # s for brakes and power before there was a proof


def held(world):
    world.say("connect")
    yield world.is_in("inactive")
    world.say("enable")
    yield world.is_in("holding")


def weaken(world, share):
    need = abs(float(world.arm._weight(world.drives.mechanics.q)[AT]))
    world.drives.mechanics._brake_limit[AT] = share * need


def begin_to_look(world):
    world.lowest[:] = world.highest[:] = world.drives.mechanics.q


def went(world):
    return float((world.highest - world.lowest).max())


@pytest.mark.by_default("0.6")
@pytest.mark.parametrize(
    ("share", "most"), [(0.85, MOST), (0.6, MOST), (0.0, 0.03)], ids=["0.85", "0.6", "none"]
)
def test_a_weak_brake_is_told_and_its_joint_held(make_world, share, most):
    world = make_world(home=[0.0, 0.9, 0.9])

    def story():
        yield from held(world)
        weaken(world, share)
        begin_to_look(world)
        world.say("disable")
        yield world.is_in("enabling")
        world.say("stop")
        world.say("disable")  # somebody is impatient
        yield world.is_in("holding")
        yield world.passes(0.3)
        assert world.state() == "holding"
        assert world.arm.fault is None
        assert went(world) < most
        assert [one.axis for one in world.arm.unheld] == [AT]
        told = [one for one in world.heard() if one.get("event") == "state"][-1]
        assert told["unheld"][0]["joint"] == AT + 1
        weaken(world, 2.0)  # somebody has supported it
        world.say("disable")
        yield world.is_in("inactive")
        assert world.arm.unheld == []

    world.run(story())
    assert world.faults == []


@pytest.mark.long
def test_a_brake_that_is_ours_alone_too(make_world):
    """By their masks nobody but we closes them: they are closed before, and opened after."""
    world = make_world(home=[0.0, 0.9, 0.9])
    for drive in world.drives.drives:
        for subindex in (1, 2):
            drive.dictionary.set(0x60FE, 1, subindex)
        drive._take_options()
        drive._set_for = 1.0

    def story():
        yield from held(world)
        assert all(brake.ours for brake in (one.brake for one in world.arm.backend.reports))
        weaken(world, 0.6)
        begin_to_look(world)
        world.say("disable")
        yield world.is_in("enabling")
        yield world.is_in("holding")
        yield world.passes(0.3)
        assert went(world) < MOST
        assert not any(drive.brake_closed for drive in world.drives.drives)
        weaken(world, 2.0)
        world.say("disable")
        yield world.is_in("inactive")

    world.run(story())
    assert world.faults == []


@pytest.mark.parametrize("ends", ["insisted on", pytest.param("at once", marks=pytest.mark.long)])
def test_who_insists_is_obeyed(make_world, ends):
    world = make_world(home=[0.0, 0.9, 0.9])

    def story():
        yield from held(world)
        weaken(world, 0.6)
        if ends == "insisted on":
            world.say("disable")
            yield world.is_in("disabling")
            yield world.passes(0.1)
        world.say("disable", anyway=True)
        yield world.is_in("fault")  # brake_slips: told as before

    world.run(story())
    assert world.faults[0].kind == "brake_slips"


def test_brakes_that_hold_cost_the_proof_and_no_more(make_world):
    world, took = make_world(home=[0.0, 0.9, 0.9]), []

    def story():
        for anyway in (False, True):
            yield from held(world) if not took else again(world)
            began = world.now
            world.say("disable", anyway=anyway)
            yield world.is_in("inactive")
            took.append(world.now - began)

    world.run(story())
    assert took[1] < BEFORE
    assert took[0] - took[1] == pytest.approx(TAKES, abs=0.02)
    assert world.faults == []


def again(world):
    world.say("enable")
    yield world.is_in("holding")


def test_an_arm_without_brakes_is_switched_off_as_ever(make_world):
    drives = [{**drive, "brake": False} for drive in joints_of_the_arm((0, 1, 2))["drives"]]
    world, took = make_world(chosen=(0, 1, 2), home=[0.0, 0.0, 0.0], drives=drives), []

    def story():
        yield from held(world)
        began = world.now
        world.say("disable")
        yield world.is_in("inactive")
        took.append(world.now - began)

    world.run(story())
    assert took[0] < BEFORE
    assert world.faults == []


def test_a_fault_meanwhile_waits_for_no_proof(make_world):
    world, took = make_world(), []

    def story():
        yield from held(world)
        world.say("disable")
        yield world.passes(0.25)
        assert world.state() == "disabling"
        began = world.now
        world.arm.emergency("daemon_gone", "test")
        yield world.is_in("fault")
        took.append(world.now - began)

    world.run(story())
    assert took[0] < 0.1
    assert world.at_rest()


ONES = np.ones(2)
LIMITS = ArmLimits(-9.0 * ONES, 9.0 * ONES, ONES, ONES, ONES, ONES, 0.15 * ONES)


def test_a_load_may_swing_beyond_what_its_brake_gives_by(make_world):
    """One of 0.84 of what its motor can bear went 6 mrad, and power stayed."""
    world = make_world(home=[0.0, 0.9, 0.9])
    mechanics = world.drives.mechanics

    def story():
        yield from held(world)
        softer = abs(float(world.arm._weight(mechanics.q)[AT])) / 0.0042 / mechanics._stiffness[AT]
        mechanics._stiffness[AT] *= softer
        mechanics._damping[AT] *= softer
        begin_to_look(world)
        world.say("disable")
        yield world.is_in("disabling")
        yield world.is_in("inactive", "holding")
        assert world.state() == "inactive"
        assert went(world) > 0.0055

    world.run(story())


def told(path, period=0.01):
    """What is said of joint 1 on this way, rad at s since its brake has its load."""
    proof, last = BrakeProof(LIMITS), path(0.0)
    for k in range(1, round(TAKES / period)):
        now, q = k * period, path(k * period)
        at, fast = np.array([q, 0.0]), np.array([(q - last) / period, 0.0])
        found = proof.see(now, at, fast, np.zeros(2, np.int64), np.ones(2, bool))
        if found:
            return found
        last = q
    return []


def test_a_brake_may_give_and_an_encoder_may_jump():
    assert told(lambda t: 0.0) == []
    assert told(lambda t: 0.004 * min(t / 0.05, 1.0)) == [], "it gave, and holds"
    assert told(lambda t: 0.012 * (1.0 - np.exp(-t / 0.01))) == [], "further, and rests"
    swings = [0.0042 * (1.0 - np.exp(-3.0 * t) * np.cos(31.0 * t)) for t in (0.0, 0.09)]
    assert swings[1] > 0.007
    for period in (0.002, 0.01):
        swing = told(lambda t: 0.0042 * (1.0 - np.exp(-3.0 * t) * np.cos(31.0 * t)), period)
        assert swing == [], "it bears nearly all that its motor can"
    assert told(lambda t: 2.0 * (t > 0.1)) == [], "its encoder jumped, or its drive began anew"
    for way in (1.0, -1.0):  # springs may outweigh gravity
        (found,) = told(lambda t, way=way: way * 0.5 * t * t)
        assert found.axis == 0
        assert 0.005 < found.gone < 0.03


def test_what_is_said():
    line = why_still_powered([Unheld(1, 0.0056)])
    assert line is not None
    assert "\n" not in line
    assert "the brake of joint 2 does not hold its load: it went 0.0056 rad" in line
    assert "upport the arm" in line
    assert "'anyway'" in line
    assert why_still_powered([]) is None
    assert Unheld.from_document(Unheld(1, 0.0056, "m").document()) == Unheld(1, 0.0056, "m")
