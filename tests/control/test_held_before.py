"""Enabling again begins with the torque that held the arm, not with what a rough URDF thinks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from arms import PERIOD, cycles, limits, servo, swing, until
from fake_backend import FakeBackend, Flywheels

from pa10d.control.arm import ALONE_AFTER, NEAR, Arm
from pa10d.control.fall import Driven
from pa10d.control.faults import Fault, LoopFault
from pa10d.control.joint_figures import presumed_figures
from pa10d.control.journal import Journal
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState
from pa10d.control.trials import Caught
from pa10d.dynamics import robot_from_profile
from pa10d.profile import load_profile
from pa10d.services.joints import learnt

INACTIVE, HOLDING = ArmState.INACTIVE, ArmState.HOLDING
LOAD = 6.0  # N·m that the arm truly needs
THOUGHT = 9.0  # N·m by the URDF


class Loaded(Flywheels):
    def step(self, torque, dt):
        super().step(np.asarray(torque) - LOAD, dt)


@pytest.fixture
def arm():
    backend = FakeBackend(Loaded(2), PERIOD)
    thought = lambda q: THOUGHT + np.zeros(2)  # noqa: E731
    arm = Arm(backend, limits(), servo, thought, Journal(Ring.create(2, 4096, PERIOD)))
    arm.connect()
    cycles(arm, 3)
    return arm


def enabled(arm):
    """rad/s of the fastest joint meanwhile."""
    began = arm.journal.count
    arm.enable()
    until(arm, HOLDING)
    rows, _ = arm.journal.ring.read(began)
    return float(np.abs(arm.journal.ring.layout.get(rows, "dq")).max())


def switched_off(arm):
    arm.disable()
    until(arm, INACTIVE)


def test_the_torque_that_held_it_comes_first(arm):
    jolt = enabled(arm)
    cycles(arm, 1000)
    assert arm.path.sent == pytest.approx([LOAD, LOAD], abs=0.1)
    switched_off(arm)
    assert enabled(arm) < 0.1 * jolt


def test_a_reset_forgets_no_torque(arm):
    jolt = enabled(arm)
    cycles(arm, 1000)
    arm.emergency("daemon_gone", "killed")
    until(arm, ArmState.FAULT)
    arm.reset()
    until(arm, INACTIVE)
    assert enabled(arm) < 0.2 * jolt


def test_a_stop_that_is_left_to_the_drives_forgets_no_torque_of_what_stood(arm):
    """Joint 2 ran away; joint 1 stood by what held it, and the URDF's torque would throw it."""
    jolt = enabled(arm)
    cycles(arm, 1000)
    arm.backend.plant.dq[1] = 1.9
    cycles(arm, 20)
    for cause in ("left its path", "does not stop as asked"):
        arm.emergency("stop", cause)
    until(arm, ArmState.FAULT)
    arm.reset()
    until(arm, INACTIVE)
    arm.backend.plant.dq[:] = 0.0
    began = arm.journal.count
    arm.enable()
    until(arm, HOLDING)
    rows, _ = arm.journal.ring.read(began)
    fastest = np.abs(arm.journal.ring.layout.get(rows, "dq")).max(axis=0)
    assert fastest[0] < 0.1 * jolt
    assert fastest[1] == pytest.approx(jolt, rel=0.2), "what drove it does not hold it"


def walled(arm):
    """From here on every joint stands where it is, whatever pushes it → what ends that."""
    plant = arm.backend.plant
    free, wall = plant.step, plant.q.copy()

    def against_a_wall(torque, dt):
        free(torque, dt)
        plant.q[:], plant.dq[:] = wall, 0.0

    plant.step = against_a_wall
    return lambda: setattr(plant, "step", free)


def test_what_pressed_against_an_obstacle_is_not_what_holds(arm):
    """Its torque is that of a servo which does not get on; powered again, with the obstacle gone,
    the joint would be thrown after it."""
    jolt = enabled(arm)
    cycles(arm, 500)
    free = walled(arm)
    arm.run(swing(arm.path.reference.q))
    until(arm, ArmState.FAULT)
    assert arm.fault.kind == "following_error"
    free()
    arm.reset()
    until(arm, INACTIVE)
    assert enabled(arm) == pytest.approx(jolt, rel=0.2)


def test_nor_does_it_after_an_ordinary_disable(arm):
    """Within its bound of the following error a joint is pressed as hard, and no fault says so."""
    jolt = enabled(arm)
    cycles(arm, 1000)
    free = walled(arm)
    arm.run(swing(arm.path.reference.q, amplitude=0.05, seconds=1.0))
    cycles(arm, 250)
    arm.stop()
    until(arm, HOLDING)
    cycles(arm, 1000)
    assert (arm.path.sent > 2.0 * LOAD).all(), "the obstacle is pressed"
    switched_off(arm)
    free()
    assert enabled(arm) == pytest.approx(jolt, rel=0.2)


def test_elsewhere_the_description_is_all_there_is(arm):
    jolt = enabled(arm)
    cycles(arm, 1000)
    switched_off(arm)
    for _ in range(500):  # by hand; a jump would be an encoder's
        arm.backend.plant.q += 1.5 * NEAR / 500
        cycles(arm, 1)
    cycles(arm, 100)
    assert enabled(arm) == pytest.approx(jolt, rel=0.2)


def test_a_new_connection_knows_nothing_of_the_last(arm):
    jolt = enabled(arm)
    cycles(arm, 1000)
    switched_off(arm)
    arm.disconnect()
    arm.connect()
    cycles(arm, 3)
    assert enabled(arm) == pytest.approx(jolt, rel=0.2)


@pytest.mark.parametrize("moving", [True, False])
def test_the_log_says_what_to_do_where_nobody_may_try_it_again(arm, caplog, moving):
    """A line of a motion that blames gains was read by all whose next try went well."""
    enabled(arm)
    cycles(arm, 200)
    if moving:
        arm.run(swing(arm.path.reference.q))
        cycles(arm, 100)
    arm.backend.plant.dq[1] = 20.0
    until(arm, ArmState.FAULT)
    (line,) = [one.getMessage() for one in caplog.records if "fault while" in one.getMessage()]
    assert f"joint 2: {arm.fault.cause}" in line
    assert (arm.fault.remedy in line) is not moving
    assert arm.fault.sentence.endswith(arm.fault.remedy)


def test_what_a_motor_could_not_hold_its_joint_does_not_weigh():
    """A URDF is wrong sooner than a motor; half of what it gives is usual for the heaviest."""
    most = limits().torque[0]
    arm = Arm(
        FakeBackend(Loaded(2), PERIOD), limits(), servo,
        lambda q: np.array([-1.1, 0.9]) * most, Journal(Ring.create(2, 4096, PERIOD)),
    )  # fmt: skip
    arm.connect()
    arm.enable()
    assert arm.path.holding.thought == pytest.approx([-0.5 * most, 0.9 * most])


def opens_one_by_one(arm):
    """Grows by how the brakes open, from now on."""
    opened = []

    class OneByOne(FakeBackend):
        out_of_brakes = None

        def begin_enable(self):
            opened.append("together")
            super().begin_enable()

        def begin_enable_one_by_one(self):
            opened.append("alone")
            super().begin_enable()

        def try_again(self):
            raise AssertionError("nothing falls")

    arm.backend.__class__ = OneByOne
    return opened


def test_brakes_open_alone_until_a_motion_has_come_to_its_end(arm):
    """An arm that is measured is held in one place, and falls in the next."""
    opened = opens_one_by_one(arm)
    for _ in range(ALONE_AFTER):
        arm._latch(Fault("not_held", "it fell", 1), RuntimeError())
        arm.fault = None
    for motion in (None, swing(np.zeros(2), 0.1, 1.0), None):
        arm.enable()
        until(arm, HOLDING)
        if motion is not None:
            cycles(arm, 1000)
            arm.run(motion)
            until(arm, HOLDING)
        switched_off(arm)
    assert opened == ["alone", "alone", "together"]


@pytest.mark.parametrize("by_drives", [False, True])
def test_an_arm_that_its_drives_stopped_on_its_way_opens_each_brake_alone(arm, by_drives):
    """Nobody has held it where it is now. Where its servo brought it to rest it was held."""
    opened = opens_one_by_one(arm)
    arm.enable()
    until(arm, HOLDING)
    cycles(arm, 1000)
    arm.run(swing(np.zeros(2), 0.1, 1.0))
    cycles(arm, 100)
    for _ in range(1 + by_drives):
        arm._on_fault(LoopFault("following_error", "fell behind", 0))
    until(arm, ArmState.FAULT)
    for _ in range(2):
        if arm.fault is not None:
            arm.reset()
            until(arm, ArmState.INACTIVE)
        arm.enable()
        until(arm, HOLDING)
        switched_off(arm)
    assert opened == ["together", "alone" if by_drives else "together", "together"]


@pytest.mark.parametrize(("far", "weighs"), [(0.1, 3.0), (1.0, 3.0)])
def test_what_was_told_goes_along_as_a_share_however_far(arm, far, weighs):
    arm._gravity = lambda q: np.array([2.0, 4.0]) * np.cos(q[0])
    arm._stood_at, arm._told = np.zeros(2), np.array([1.0, 0.0])
    arm.path.q[:] = far, 0.0
    assert arm._thought() == pytest.approx(np.array([weighs, 4.0]) * np.cos(far))


def described() -> np.ndarray:
    """N·m (2,) by a description that says nothing."""
    return np.zeros(2)


@pytest.mark.parametrize(
    ("tried", "share", "lets"),
    [
        ([None], 0.2, True),
        ([None], 0.4, False),
        ([[0]], 0.4, True),
        ([[0]], 0.7, False),
        ([[0], [], [1], [], None], 0.4, True),
    ],
)
def test_a_joint_alone_has_time_to_be_caught(arm, tried, share, lets):
    """Its servo brings back a light joint that lacks little, and takes no other along; joints that
    were held alone are shaken as all brakes open, and do not fall."""
    arm.enable()
    for out in tried:
        arm.path.brakes.try_alone(out, described)
    arm.path.dq[0] = share * limits().velocity[0]

    def watched():
        for _ in range(20):
            arm.path.time += PERIOD
            arm.path.watch_standing()

    if lets:
        watched()
    else:
        with pytest.raises(LoopFault, match="more than it may"):
            watched()


def test_a_joint_keeps_the_torque_that_held_it_alone(arm):
    """Its own brake is closed again; another is tried, and what it does moves nobody's place."""
    arm.enable()
    path, tried = arm.path, arm.path.controller
    path.brakes.try_alone([0], described)
    for _ in range(3):
        path.q[0] -= 1e-3
        path.brakes.try_alone([0], described)
        sent = path.torque(ArmState.ENABLING).copy()
    assert path.reference.q[0] - path.q[0] == pytest.approx(3e-3)
    assert sent[0] > THOUGHT + 0.5
    path.brakes.try_alone([], described)
    assert path.holding.thought == pytest.approx([sent[0], THOUGHT])
    assert path.reference.q == pytest.approx(path.q)
    path.brakes.try_alone([1], described)
    path.q[0] += 1e-4
    path.brakes.try_alone([1], described)
    path.dq[:] = 0.0
    assert tried.torque(path.reference, path.q, path.dq)[0] == pytest.approx(sent[0], abs=1e-6)


def test_bodies_of_a_urdf_alone_are_not_told_as_felt():
    """Else an arm counts as weighed before it was, and what its motors could not hold is believed
    all the same."""
    profile = load_profile("pa10-sim")
    robot = robot_from_profile(profile)
    known = learnt(profile, robot, presumed_figures(robot))
    assert known.felt is None
    bodies = np.stack([1.1 * robot.parameters, 1.2 * robot.parameters])
    weighed = replace(known, figures=known.figures.but(bodies=bodies))
    assert np.array_equal(weighed.felt, bodies[0])


def test_what_was_told_goes_along_as_others_move(arm):
    """The one that is weighed now as it is; those that are free are held by their servos."""
    path = arm.path
    path.power_up(np.array([2.0, 6.0]), np.array([1.0, 3.0]))
    path.brakes.try_alone([], described)
    path.brakes.take_along(np.array([1.5, 2.0]), 1)
    assert path.holding.thought == pytest.approx([3.0, 6.0])
    path.brakes.take_along(np.array([1.5, 1.0]), None)
    assert path.holding.thought == pytest.approx([3.0, 3.0])
    path.brakes.take_along(np.array([-0.1, 1.0]), None)
    assert path.holding.thought == pytest.approx([2.0, 3.0]), "near zero it is all error"
    path.brakes.take_along(np.array([1.5, 1.0]), None)
    path.brakes.try_alone([0], described)
    path.brakes.take_along(np.array([1.0, 1.5]), None)
    assert path.holding.thought == pytest.approx([3.0, 4.5])


@pytest.mark.parametrize(("before", "again"), [(0.1, True), (0.05, False)])
def test_one_that_gets_faster_and_tells_nothing_is_given_no_more(arm, monkeypatch, before, again):
    """Its torque may act the wrong way round; one that slides on is not held by enough."""
    path = arm.path
    path.power_up(np.array([2.0, 6.0]))
    path.brakes.try_alone([0], described)
    monkeypatch.setattr(path.holding._falls, "driven", lambda axis: Driven(1.9, 0.5))
    monkeypatch.setattr(path.holding._falls, "weighed", lambda *_: None)
    path.exit.sent[0] = 1.9
    path.q[0] += 0.5 * limits().following_error[0]
    path.dq[0], path._dq_before[0] = 0.1, before
    assert path.brakes.try_alone([0], described) is again
    assert path.holding.thought[0] == pytest.approx(1.8 if again else 2.0)


def test_a_joint_that_goes_on_until_its_brake_has_it_is_held_by_what_it_weighs_there(arm):
    """Gravity turned it further over while its drive stopped it: it was begun with what it had
    weighed before, and fell again, four times and 1.3 rad."""
    path = arm.path
    path.power_up(np.array([2.0, 6.0]))
    path.brakes.try_alone([0], lambda: np.array([1.0, 6.0]))
    path.brakes._caught = Caught(0, (0.1, 1.0), 0.5, 7.0)
    path.brakes._tried_at = 1.0
    path.brakes.try_alone([], lambda: np.array([1.3, 6.0]))
    path.brakes.try_alone([0], lambda: np.array([1.5, 6.0]))
    assert path.holding.thought[0] == pytest.approx(3.0)
