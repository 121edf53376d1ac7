"""A joint that is not held as its brake opens shows what it weighs by the way it falls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from arm_bench import ArmBench
from arms import PERIOD, cycles, limits, servo, until
from fake_backend import FakeBackend, Flywheels

from pa10d.control.arm import RESTS, Arm
from pa10d.control.fall import (
    LACKING,
    SURE,
    Driven,
    FallWatch,
    Tried,
    Weighed,
    driven,
    roughly,
    weight_of,
)
from pa10d.control.gains import PidGains
from pa10d.control.journal import Journal
from pa10d.control.pid import Pid
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState

J, WEIGHT, RUBS = 0.02, 1.0, 0.1  # kg·m², N·m, N·m


def falling(pushes, seconds=0.1, period=0.004, noise=0.0, sign=1.0):
    """s, rad and N·m as they are seen: a joint that weighs WEIGHT and rubs, pushed back by its
    servo with ``pushes`` N·m/rad. One cycle passes until a torque acts."""
    rng = np.random.default_rng(3)
    t, q, sent, v = [0.0], [0.0], [0.3], 0.0
    while t[-1] < seconds:
        before, v = v, min(0.0, v + period / J * (sign * sent[-1] - WEIGHT + RUBS))
        q.append(q[-1] + period * 0.5 * (before + v))
        t.append(t[-1] + period)
        sent.append(0.3 - pushes * (q[-2] if len(q) > 2 else 0.0))
    return np.array(t), np.array(q) + noise * rng.standard_normal(len(q)), np.array(sent)


def test_weight_beside_friction_is_told_from_inertia_by_what_pushes_back():
    found = weight_of(*falling(8.0))
    assert found.torque == pytest.approx(WEIGHT - RUBS, abs=0.01)


def test_its_error_is_what_noise_makes_of_it():
    found = weight_of(*falling(8.0, noise=2e-5))
    assert 0 < abs(found.torque - (WEIGHT - RUBS)) < 4 * found.error
    assert found.error < 0.1


def test_a_torque_that_never_changes_tells_no_weight():
    """Whether it is heavy and inert, or neither."""
    assert weight_of(*falling(0.0)) is None


def test_nor_does_one_of_the_wrong_sign():
    assert weight_of(*falling(8.0, sign=-1.0)) is None


def seen(t, q, sent):
    watch = FallWatch(1)
    for row in zip(t, q, sent, strict=True):
        watch.see(row[0], np.array(row[1:2]), np.array(row[2:3]))
    return watch


def test_only_what_comes_surely_nearer_counts_and_nothing_that_no_weight_can_be():
    clear, early = seen(*falling(8.0)), falling(8.0, seconds=0.06, noise=1e-5)
    assert clear.weighed(0, 0.3, 3.0) is not None
    assert clear.weighed(0, 0.3, 0.8) is None, "more than it may weigh"
    assert seen(*early).weighed(0, 0.3, 3.0) is not None
    assert weight_of(*early).error > LACKING / SURE * 0.05
    assert seen(*early).weighed(0, 0.8, 3.0) is None, "it may be no nearer than what is thought"


@pytest.mark.parametrize("slipped", [0.0, 2e-3])
def test_what_was_lacking_is_counted_from_what_was_thought(slipped):
    """Torque comes up while the brake holds, and a brake may slip before it opens: rows before tell
    nothing of how much was lacking."""
    t, q, sent = falling(8.0, seconds=0.035, period=0.01)
    before = np.arange(-9.0, 0.0) * 0.01
    braked = np.array(3 * [0.0] + 6 * [-slipped])
    torque = np.array(2 * [0.0] + 7 * [0.3])
    rows = np.append(before, t), np.append(braked, q - slipped), np.append(torque, sent)
    whole = seen(*rows).weighed(0, 0.3, 3.0, J)
    assert whole.between == pytest.approx(roughly(t, q, sent, J).between)


@pytest.mark.parametrize("times", [1 / 3, 1.0, 3.0])
@pytest.mark.parametrize("stiff", [None, 120.0])
def test_two_periods_are_enough_to_come_nearer(times, stiff):
    """Of a rotor that its spring pulls along, or of a joint that slides: 1e-3 m is half of its way
    until it is too fast. No slope can be fitted; what speed it has after what way says enough."""
    t, q, sent = falling(8.0, seconds=0.03, period=0.01)
    if stiff is not None:  # N·m/rad, of a rotor before a link that hangs in its spring
        q = -(WEIGHT - RUBS - 0.3) / stiff * (1.0 - np.cos(np.sqrt(stiff / J) * t))
    found = roughly(t[:4], q[:4], sent[:4], times * J)
    assert 0.3 < min(found.between) < WEIGHT - RUBS
    assert abs(found.torque - (WEIGHT - RUBS)) < WEIGHT - RUBS - 0.3


@pytest.mark.parametrize("way", [(0, -4e-4, -1.4e-3, -1.7e-3), (0, 3e-4, -2e-4, -1.6e-3)])
def test_a_joint_that_slowed_down_or_turned_was_moved_by_something_else(way):
    t, q, sent = falling(0.0, seconds=0.03, period=0.01)
    assert driven(t[:4], q[:4], sent[:4]) is not None
    assert driven(t[:4], np.array(way, float), sent[:4]) is None


@pytest.mark.parametrize("times", [1 / 3, 0.5, 1.0, 2.0, 3.0])
def test_of_a_joint_that_is_gone_at_once_the_next_try_comes_nearer(times):
    """However wrong the inertia is that is presumed of it, within what it may be wrong by."""
    fall = falling(8.0, seconds=0.035, period=0.01)
    assert weight_of(*fall) is None
    found = roughly(*fall, times * J)
    low, high = found.between
    assert 0.3 < low < WEIGHT - RUBS + 1e-3
    assert high > WEIGHT - RUBS - 1e-3
    assert abs(found.torque - (WEIGHT - RUBS)) < 0.85 * (WEIGHT - RUBS - 0.3)


def test_where_it_is_not_sure_what_lacked_nothing_is_begun_with():
    assert roughly(*falling(8.0, seconds=0.03, noise=1e-3), J) is None
    assert roughly(*falling(20.0, seconds=0.06, sign=-1.0), J) is None, "it pushes the wrong way"


def wrist(weighs, turns):
    """The PA10's at 100 Hz, without friction, turned to where gravity pulls at it most; turns:
    share of its inertia."""
    more = {key: [1, 1, 1, 1, 1, by, by] for key, by in (("mass", weighs), ("inertia", turns))}
    return ArmBench(100.0, friction=0.0, pose=[0, 0, 0, 0, 0, np.pi / 2, 0], **more)


@pytest.mark.parametrize("weighs", [2.0, 3.0, 0.3])
def test_a_wrist_that_its_urdf_weighs_wrongly_is_caught(weighs):
    """The servo alone is too weak there: of three times its weight it fell by 0.49 rad."""
    arm = wrist(weighs, weighs)
    start, began = arm.plant.measure()[0], arm.ring.written
    arm.arm.enable()
    cycles(arm.arm, 150)
    assert arm.arm.fault is None
    rows, _ = arm.ring.read(began)
    went = np.abs(arm.ring.layout.get(rows, "q") - start).max(axis=0)
    assert went[5] < 0.25


def test_one_that_falls_too_fast_for_that_is_held_the_next_time():
    """Heavy, and hardly inert. Brakes catch it; enabling again begins with what it weighs."""
    arm = wrist(3.0, 1.0)
    fault = arm.enable()
    assert (fault.kind, fault.joint, fault.weighed) == ("not_held", 6, 6)
    assert "0.33 N·m was to hold it" in fault.sentence
    assert "about 0.99 N·m would have held it" in fault.sentence
    arm._reset()
    assert arm.enable() is None


def test_the_next_enabling_begins_with_what_no_servo_has_found():
    """Nor is anything begun with that no weight can be, whatever the fall looks like."""
    for heaviest, begins in ((10.0, 6.0), (2.0, 0.5)):
        arm = fallen(heaviest)
        assert arm.fault.weighed == int(heaviest > 6.0)
        until(arm, ArmState.FAULT)
        again(arm)
        assert arm.path.holding.thought[0] == pytest.approx(begins, abs=0.2)


class Falls(Flywheels):
    """Of two joints the first weighs 6 N·m."""

    def step(self, torque, dt):
        super().step(np.asarray(torque) - np.array([6.0, 0.0]), dt)


def again(arm):
    """It is powered once more."""
    arm.reset()
    until(arm, ArmState.INACTIVE)
    arm.enable()


def the_second_falls(arm, said):
    """… and that ends it, with the first one weighed."""
    arm.backend.plant.dq[1] = 1.5
    until(arm, ArmState.FAULT)
    assert arm.fault.joint == 2
    assert said in arm.fault.cause
    assert arm.fault.weighed == 1
    again(arm)
    assert arm.path.holding.thought[0] == pytest.approx(6.0, abs=0.3)


def fallen(heaviest, slides=()):
    """An arm whose servo is too weak to hold a joint that weighs more than is thought."""
    firm = servo().gains
    weak = PidGains(0.02 * firm.kp, 0.0 * firm.ki, 0.2 * firm.kd)
    arm = Arm(
        FakeBackend(Falls(2), PERIOD),
        replace(limits(), slides=frozenset(slides)),
        lambda: Pid(weak, limits().torque, PERIOD),
        lambda q: np.array([0.5, 0.0]),
        Journal(Ring.create(2, 4096, PERIOD)),
        np.array([heaviest, 1.0]),
        rests=0.0,
    )
    arm.connect()
    cycles(arm, 3)
    arm.path.holding.catch = lambda: None  # it is to fall
    arm.enable()
    until(arm, ArmState.FAULT)
    return arm


def test_of_a_slide_it_is_said_in_metres_and_newtons():
    turns, slides = fallen(10.0).fault.cause, fallen(10.0, [0]).fault.cause
    assert "rad" in turns
    assert "N·m" in turns
    for unit, own in (("rad/s", "m/s"), (" rad", " m"), ("N·m", "N")):
        turns = turns.replace(unit, own)
    assert slides == turns


def test_whoever_enables_it_knows_whether_it_is_tried_again_and_the_log_does_not(caplog):
    fault = fallen(10.0).fault
    assert fault.weighed
    assert "'reset' and enable again" in fault.sentence
    assert fault.seen in caplog.text
    assert "'reset'" not in caplog.text


def test_one_that_was_caught_is_held_again_by_what_it_weighs_whoever_ends_it():
    arm = fallen(10.0)
    arm.reset()
    until(arm, ArmState.INACTIVE)
    arm._held_by = None
    del arm.path.holding.catch
    arm.enable()
    until(arm, ArmState.HOLDING)
    arm.state = ArmState.ENABLING  # it stands; had it swayed it would be that still
    the_second_falls(arm, "joint 1 fell, too")


def test_what_one_joint_told_is_not_forgotten_as_another_falls():
    arm = fallen(10.0)
    until(arm, ArmState.FAULT)
    again(arm)
    knew = arm.path.holding.thought[0]
    cycles(arm, 6)
    arm.backend.plant.dq[1] = 1.5
    until(arm, ArmState.FAULT)
    assert arm.fault.joint == 2
    arm.reset()
    until(arm, ArmState.INACTIVE)
    arm.weigh(lambda q: np.array([0.6, 0.1]))  # as with other gains, after a swing
    arm.enable()
    assert arm.path.holding.thought == pytest.approx([knew, 0.1], abs=0.2)


def test_nor_as_another_one_ends_it_once_the_arm_is_held():
    """Held, and on a motion near by, a joint that does not stand is held by what is known of it
    when it is powered again, not by a rough URDF."""
    arm = fallen(10.0)
    again(arm)
    until(arm, ArmState.HOLDING)
    knew = arm.path.holding.thought[0]
    arm.backend.plant.dq[:] = 0.5, 3.0
    until(arm, ArmState.FAULT)
    again(arm)
    assert arm.path.holding.thought[0] == pytest.approx(knew, abs=0.2)


def test_a_joint_that_is_taken_along_is_not_the_one_that_is_weighed():
    arm = fallen(10.0)  # of it nothing is kept but how it is made
    arm.reset()
    until(arm, ArmState.INACTIVE)
    arm._held_by = None
    arm.enable()
    while np.abs(arm.backend.plant.q - arm._stood_at)[0] < 0.03:
        arm.cycle()
    the_second_falls(arm, "joint 1 has fallen farther and taken it along")
    assert arm.path.holding.thought[1] == pytest.approx(0.0, abs=1e-9)


def test_what_is_learnt_later_counts_for_joints_that_were_held_by_what_was_thought():
    arm = fallen(10.0)  # the first joint was weighed as it fell, of the second one nothing is known
    arm.reset()
    until(arm, ArmState.INACTIVE)
    arm.weigh(lambda q: np.array([5.0, 2.0]))
    arm.enable()
    assert arm.path.holding.thought == pytest.approx([6.0, 2.0], abs=0.3)


def test_a_joint_that_went_far_is_held_by_as_many_times_what_its_urdf_says():
    """Its brake took long; a body that is twice as heavy is that anywhere."""
    arm = fallen(10.0)
    there = arm.path.q.copy()
    arm.weigh(lambda q: np.array([2.5 - (q[0] - there[0]), 0.0]))
    arm.backend.plant.q[0] -= 1.0
    arm.path.measured_q[0] -= 1.0
    arm.path._speed.restart()
    arm.cycle()
    arm._take_along()
    assert arm._held_by[1][0] == pytest.approx(6.0 / 2.5 * 3.5, rel=0.2)


def test_what_was_tried_and_was_too_little_or_too_much_is_not_begun_with_again():
    """A spring that unwinds looks like more than was lacking, so that falls go to and fro."""
    tried, described = Tried(2), 12.0
    far, near = Weighed(36.0, 5.0, (20.0, 90.0)), Weighed(17.0, 1.0)
    assert tried.between(1, (12.0, 12.0), described, -0.02, far) is far
    found = tried.between(1, (30.0, 30.0), 10.0, 0.02, Weighed(9.0, 5.0))  # and sagged meanwhile
    assert found.torque == pytest.approx(0.5 * (1.0 + 3.0) * 10.0)
    assert tried.between(1, (20.0, 20.0), 10.0, -0.02, None).torque == pytest.approx(25.0)
    assert tried.between(1, (29.0, 29.0), 10.0, 0.02, far).torque == pytest.approx(24.5)
    slow, good = Weighed(24.0, 0.01), Weighed(23.0, 0.01)
    assert tried.between(1, (24.2, 24.2), 10.0, 0.02, slow).torque == pytest.approx(22.1), (
        "a step at most"
    )
    assert tried.between(1, (24.2, 24.2), 10.0, 0.02, good) is good
    assert tried.between(0, (12.0, 12.0), described, -0.02, near) is near, "another joint"
    assert tried.between(1, (29.5, 29.5), 10.0, -0.02, far) is far, "it carries more by now"
    assert tried.between(1, (2.0, 2.0), 0.01, -0.02, far) is far, "no share of next to nothing"


def test_two_falls_tell_inertia_and_weight_apart_of_a_payload_that_nobody_described():
    """Ten times as inert as presumed and seven times as heavy: what one fall says is too little."""
    inertia, weight, rubs = 0.03, -2.28, 0.24
    tried, thought, falls = Tried(1), -0.34, 0
    while abs(weight - thought) > rubs:
        rise = (thought - weight - rubs) / inertia
        rough = Weighed(thought - 0.1, 0.1, (thought - 0.05, thought - 0.4))
        found = tried.again(0, -0.34, Driven(thought, rise), rough)
        found = tried.between(0, (thought, thought), -0.34, 0.02, found)
        thought, falls = found.torque, falls + 1
    assert falls == 2
    assert found.again
    assert thought == pytest.approx(weight + rubs, abs=0.01)


def dragged(begin, lacking, drag=0.4, damping=0.1, fast=1.25, period=0.002):
    """s, rad and N·m of a joint alone, of J, that viscous friction slows as it falls."""
    t, q, sent, v = [0.0], [0.0], [begin], 0.0
    while abs(v) < fast:
        before, v = v, v + period / J * (sent[-1] - begin - lacking - drag * v)
        q.append(q[-1] + period * 0.5 * (before + v))
        t.append(t[-1] + period)
        sent.append(begin - damping * v)
    return np.array(t), np.array(q), np.array(sent)


def watched(begin, lacking, **how):
    watch = FallWatch(1)
    for time, q, sent in zip(*dragged(begin, lacking, **how), strict=True):
        watch.see(time, np.array([q]), np.array([sent]))
    return watch


def test_what_viscous_friction_hides_of_one_fall_two_falls_tell():
    """It slows a joint as its servo's damping does, which then looks a fifth as inert and a
    fifth as much in want. Both falls are slowed alike, and differ by what was given."""
    tried, begin, weight = Tried(1), 1.0, 3.0
    for fall in range(2):
        watch = watched(begin, weight - begin)
        found = watch.weighed(0, begin, 10.0, 0.3 * J)
        assert found.between is None
        one, begun = found.torque, begin
        begin = tried.again(0, 2.0, watch.driven(0), found, True, 0.3 * J).torque
        assert (begin == one) == (fall == 0)
    assert one - begun < 0.3 * (weight - begun)
    assert begin - begun > 0.6 * (weight - begun)
    assert begin < weight
    others = Tried(1)
    for push, rise in ((1.0, 90.0), (1.4, 70.0)):
        found = others.again(0, 2.0, Driven(push, -rise), Weighed(push + 0.1, 0.01), False, J)
    assert found.torque == 1.5, "others moved it, too"


def test_a_fall_of_which_nothing_is_sure_is_told_by_the_one_before():
    tried = Tried(1)
    assert tried.again(0, 2.0, Driven(1.0, -90.0), None, True, J) is None
    found = tried.again(0, 2.0, Driven(1.4, -70.0), None, True, J)
    assert found.torque == pytest.approx(1.4 + 0.02 * 70.0)
    assert found.again
    found = tried.again(0, 2.0, Driven(3.0, -60.0), None, True, J)
    assert found.torque == pytest.approx(3.0 + 3.0 * J * 60.0), "no more inert than any may be"
    assert tried.again(0, -1.0, Driven(3.2, -40.0), None, True, J) is None, "it leans otherwise"


def test_no_joint_is_taken_for_lighter_than_any_may_be():
    """As light as one that friction slows looks."""
    watch = watched(1.0, 2.0)
    rough, alone = watch.weighed(0, 1.0, 10.0, J), watch.weighed(0, 1.0, 10.0)
    assert alone.torque - 1.0 < 0.3 * 2.0
    assert rough.torque == min(rough.between, key=lambda one: abs(one - 1.0))
    assert alone.torque < rough.torque < 3.0
    light = watch.weighed(0, 1.0, 10.0, 0.1 * J)
    assert light == alone, "it may be as light as that"


def test_what_is_no_share_of_its_bodies_is_taken_as_it_was_found():
    """As another joint turned, its described weight passed zero, and what it lacks did not."""
    tried, other, good = Tried(1), Weighed(-0.024, 1e-3), Weighed(0.08, 1e-3)
    tried.between(0, (-0.09, -0.065), -0.065, 0.02, None)
    assert tried.between(0, (-0.02, 0.026), 0.02, 0.02, other) is other
    assert tried.between(0, (0.09, 0.13), 0.1, 0.02, good) is good, "what was tried there is gone"


def test_of_a_joint_that_falls_as_before_twice_as_much_is_lacking():
    tried, rough = Tried(1), Weighed(6.0, 1.0, (5.5, 12.0))
    assert tried.again(0, 4.0, Driven(4.0, -30.0), rough) is rough
    assert tried.again(0, 4.0, Driven(5.0, -29.5), rough).torque == 7.0
    assert tried.again(0, 4.0, Driven(5.0, -60.0), rough) is rough, "something else drives it"
    assert tried.again(0, 4.0, Driven(12.0, 20.0), rough) is rough, "the other way"
    assert tried.again(0, 4.0, Driven(9.0, 15.0), None) is None


def test_links_that_swing_in_their_brakes_rest_before_the_next_enabling():
    """No encoder sees them; a fall leaves them swinging."""
    arm = fallen(10.0)
    arm._rests = RESTS
    fell = arm.path.time
    arm.reset()
    until(arm, ArmState.INACTIVE)
    assert arm.path.time - fell > 0.9 * RESTS
    arm.emergency("x", "y")
    arm.fault = None
    arm.reset()
    fell = arm.path.time
    until(arm, ArmState.INACTIVE)
    assert arm.path.time - fell < 0.1


def test_two_falls_tell_no_more_than_a_joint_may_weigh():
    arm = fallen(10.0)
    arm.path.holding._tried.again = lambda *_: Weighed(1e3, 1.0, again=True)
    assert arm.path.holding._weighed(0).torque == 10.0
