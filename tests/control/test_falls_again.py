"""A joint with dry friction that falls the same way again and again is held before long."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from arms import cycles, limits, until
from fake_backend import FakeBackend

from pa10d.control.arm import Arm
from pa10d.control.carried import carried
from pa10d.control.fall import FallWatch, Tried, Weighed
from pa10d.control.gains import PidGains
from pa10d.control.journal import Journal
from pa10d.control.pid import Pid
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState

PERIOD = 0.01


class Rubs:
    """One joint that weighs less the farther it goes up, faster than its servo gets firmer."""

    n = 1

    def __init__(self, weight, slope, dry, inertia=0.4, wet=0.8):
        self.weight, self.slope, self.dry = weight, slope, dry
        self.inertia, self.wet = inertia, wet
        self.q, self.dq = np.zeros(1), np.zeros(1)

    def reset(self, q0):
        self.q, self.dq = np.array(q0, float), np.zeros(1)

    def weighs(self):
        return self.weight + self.slope * self.q

    def step(self, torque, dt):
        h = dt / 10
        for _ in range(10):
            free = self.dq + h / self.inertia * (torque - self.weighs() - self.wet * self.dq)
            self.dq = free - np.clip(
                free, -h * self.dry / self.inertia, h * self.dry / self.inertia
            )
            self.q = self.q + h * self.dq

    def measure(self):
        return self.q.copy(), np.zeros(1)


class Goes:
    """One joint that goes a way of its own, rad a period, whatever it is given."""

    n = 1

    def __init__(self, way):
        self.way, self.gone, self.q = np.asarray(way, float), 0, np.zeros(1)

    def reset(self, q0):
        self.q = np.array(q0, float)

    def step(self, torque, dt):
        self.gone = min(self.gone + 1, len(self.way) - 1)
        self.q = self.way[self.gone : self.gone + 1].copy()

    def measure(self):
        return self.q.copy(), np.zeros(1)


class StandsUp(Rubs):
    """One joint with its link above it, whose brake drags before it holds."""

    DRAGS = 3  # periods

    def __init__(self, heavy, q, dry=0.032, inertia=0.0036, wet=0.04):
        super().__init__(0.0, 0.0, dry, inertia, wet)
        self.heavy, self.dragged = heavy, 0
        self.reset([q])

    def weighs(self):
        return -self.heavy * np.sin(self.q)

    def reset(self, q0):
        """In its brake."""
        self.dragged += 1
        slip = 0.7**self.dragged * self.dq if self.dragged <= self.DRAGS else np.zeros(1)
        self.q, self.dq = np.array(q0, float) + PERIOD * slip, slip

    def step(self, torque, dt):
        self.dragged = 0
        super().step(torque, dt)


def powered(plant, thought, slope=0.0, firm=1.0, pid=(4.9, 8.2, 0.97), far=0.15, **options):
    """An arm whose brake is to open. thought: N·m where it stands, and N·m/rad, or all of it by a
    pose; firm: of gains."""
    gains = PidGains(*(firm * gain * np.ones(1) for gain in pid))
    bound = replace(limits(1), following_error=far * np.ones(1))
    arm = Arm(
        FakeBackend(plant, PERIOD),
        bound,
        lambda: Pid(gains, bound.torque, PERIOD),
        thought if callable(thought) else lambda q: thought + slope * q,
        Journal(Ring.create(1, 4096, PERIOD)),
        np.array([35.0]),
        rests=0.0,
        **options,
    )
    arm.connect()
    cycles(arm, 3)
    return arm


def falls(plant, thought, **options):
    """How often it is not held, ten times at most."""
    arm = powered(plant, thought, **options)
    for count in range(10):
        arm.enable()
        until(arm, ArmState.HOLDING, ArmState.FAULT, seconds=100.0)
        cycles(arm, 300)
        if arm.state == ArmState.HOLDING:
            return count
        until(arm, ArmState.FAULT)
        arm.reset()
        until(arm, ArmState.INACTIVE)
    return 10


@pytest.mark.by_default("0.5-7.9--12.0-1.0")
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    ("inertia", "weight", "slope"), [(0.25, 7.9, -9.0), (0.5, 7.9, -12.0), (0.5, 5.0, -9.0)]
)
def test_a_weight_that_goes_with_the_way_is_not_run_after(side, inertia, weight, slope):
    """Each fall told the least that would have held the joint where it had stood, and each went on
    to where it weighs less: by as much as it rubs, each time. Ten falls did not hold it."""
    assert falls(Rubs(side * weight, slope, 1.3, inertia), side * 11.1) <= 3


@pytest.mark.by_default("1.2-1.0", "1.5-1.0")
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("heavy", [1.2, 1.5])
def test_a_link_heavier_than_described_is_so_where_its_brake_has_it_too(side, heavy):
    """Each fall told what it weighed where it had stood, and it was begun 0.05 rad on with the
    half or third of the change that its description knew: five of eight were not held."""
    pid, tried = (0.4, 0.16, 0.02), []
    for stands in (0.2, 0.4):
        for presumed in (0.0012, 0.0036):
            inertia = 2 * (np.array([presumed]),)
            tried.append(
                falls(
                    StandsUp(heavy, side * stands),
                    lambda q: -0.5 * np.sin(q),
                    pid=pid,
                    far=0.18,
                    inertia=inertia,
                )
            )
    assert max(tried) < 10
    assert np.mean(tried) < 6.0


def test_what_was_told_goes_along_as_a_share():
    told, there, here = (
        np.array([3.0, 3.0, -3.0]),
        np.array([2.0, 2.0, -9.0]),
        np.array([4.0, -1.0, -6.0]),
    )
    assert carried(told, there, here) == pytest.approx(
        1.5 * np.array([4.0, -1.0, 0.0]) + [0, 0, -2.0]
    )


def test_what_is_known_by_the_description_alone_stays_what_it_says():
    """To the last bit, by which it is told from what was felt."""
    there, here = np.random.default_rng(321).uniform(-9.0, 9.0, (2, 1000))
    there[:3] = 0.0
    assert (carried(there, there, here) == here).all()


def test_what_no_masses_explain_goes_along_as_it_is():
    told, there, here = (
        np.array([3.0, -3.0, 3.0]),
        np.array([0.5, 1.0, 0.0]),
        np.array([1.0, 2.0, 1.0]),
    )
    assert carried(told, there, here) == pytest.approx(told + here - there)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_a_fall_told_is_told_of_where_it_began(side):
    """The joint has gone on by then, and weighs the same share of what its description says."""
    arm = powered(Rubs(side * 7.9, -9.0, 1.3, 0.5), side * 11.1, -9.0)
    arm.enable()
    until(arm, ArmState.FAULT)
    told, stood = arm.path.holding.fell[0].torque, arm._stood_at[0]
    arm.reset()
    until(arm, ArmState.INACTIVE)
    arm.enable()
    way = arm.path.q[0] - stood
    assert abs(way) > 0.05
    there = side * 11.1 - 9.0 * stood
    assert arm.path.holding.thought[0] == pytest.approx(told * (1.0 - 9.0 * way / there))


def test_of_falls_the_same_way_as_many_times_is_lacking_as_they_found():
    """And no more often than it fell, however little the first one told."""
    tried = Tried(2)
    assert tried.same_way(0, 7.5, 9.0, Weighed(6.2, 0.1)).torque == pytest.approx(6.2)
    assert tried.same_way(0, 6.0, 8.9, Weighed(5.1, 0.1)).torque == pytest.approx(
        6.0 - 0.9 * (1.3 + 0.9) / 1.3
    )
    assert tried.same_way(0, 4.5, 8.9, Weighed(2.0, 0.1)).torque == pytest.approx(4.5 - 3.0 * 2.5)
    assert tried.same_way(1, 4.5, 8.9, Weighed(2.0, 0.1)).torque == 2.0, "another joint"
    back = tried.same_way(0, -3.0, 8.9, Weighed(-1.0, 0.1))
    assert (back.torque, back.again) == (-1.0, False), "too much by now"
    assert tried.same_way(0, -1.0, 8.9, None) is None


def test_a_joint_that_was_not_given_what_it_told_has_told_no_less_than_there_is():
    tried = Tried(1)
    tried.same_way(0, 0.5, 0.5, Weighed(6.0, 0.1))
    assert tried.same_way(0, 0.5, 0.5, Weighed(6.0, 0.1)).torque == 6.0
    assert tried.same_way(0, 5.0, 5.0, Weighed(6.0, 0.1)).torque == 6.0, "it stands elsewhere"


def test_what_told_more_by_other_falls_is_taken_as_it_is():
    tried, far = Tried(1), Weighed(5.1, 0.1, again=True)
    tried.same_way(0, 7.5, 9.0, Weighed(6.2, 0.1))
    assert tried.same_way(0, 6.0, 8.9, far) is far


def test_a_joint_that_its_servo_throws_up_does_not_weigh_less_than_was_thought():
    """It hung in its spring, and was pushed with more than it weighs."""
    watch = FallWatch(1)
    for k, (q, sent) in enumerate([(0.0, 6.3), (0.004, 7.0), (0.01, 5.9), (0.02, 5.7)]):
        watch.see(0.005 * k, np.array([q]), np.array([sent]))
    under = watch.under(0, 5.7)
    assert under == (5.9, 7.0)
    tried, found = Tried(1), Weighed(6.4, 0.1)
    tried.between(0, (5.2, 5.2), 5.0, -0.01, None)
    assert tried.between(0, under, 5.0, 0.02, found) is found
    assert FallWatch(1).under(0, 5.7) == (5.7, 5.7), "nobody saw it"


SAGS = [0.0, -0.001, -0.003, -0.006, -0.01, -0.014, -0.018, -0.022, -0.025, -0.027, -0.028, -0.0282]


def thrown(way, thought, rough):
    """An arm whose joint was faster than it may be on this way. rough: kg·m², 3 times off."""
    arm = powered(Goes(way), thought, firm=3.0, inertia=(np.array([rough]), np.array([rough])))
    arm.enable()
    until(arm, ArmState.FAULT)
    return arm


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_joint_that_is_thrown_back_to_its_place_tells_no_weight_roughly(side):
    """It sagged under 5.9 N·m, so that it weighs more, and what its spring had taken up threw it
    back: by the inertia of all that hangs on it 0.28 N·m was told, and 15 N·m the other way."""
    arm = thrown(side * np.array([*SAGS, -0.024, -0.015, -0.004]), side * 5.9, 0.3)
    assert arm.path.holding.fell == {}
    assert arm.fault is not None
    assert arm.fault.kind == "not_held"
    holding = arm.path.holding
    low, high = holding._tried._low[0], holding._tried._high[0]
    assert low == -np.inf
    assert high * 5.9 == pytest.approx(max(abs(one) for one in holding._falls.under(0, 0.0)))
    assert high > 1.0, "it was given more than it thought as it went up"


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_joint_that_was_caught_and_is_thrown_back_weighs_what_it_was_caught_by(side, monkeypatch):
    caught, rough = Weighed(side * 6.7, 0.03), Weighed(side * -15.0, 10.0, (0.0, side * -100.0))

    def weighed(watch, axis, thought, most, inertia=None):
        if abs(watch.way(axis)) > 0.02 and watch.way(axis) * side < 0.0:
            return caught
        return None if inertia is None else rough

    monkeypatch.setattr(FallWatch, "weighed", weighed)
    arm = thrown(
        side * np.array([*SAGS[:-2], -0.03, -0.033, -0.035, -0.0352, -0.031, -0.022, -0.011]),
        side * 5.9,
        0.3,
    )
    assert arm.path.holding.fell == {0: caught}


@pytest.mark.parametrize(("begins", "told"), [(1.7, True), (2.2, False)])
def test_a_joint_that_breaks_loose_in_the_first_seconds_falls_until_it_stands(begins, told):
    """It rubbed where it had slid to, until its servo pushed enough, and was beyond its place when
    the first seconds were over: no collision was to be looked for. What stood until then was held.
    """
    slid = [0.0, 0.001, 0.003, 0.006, 0.01, 0.014, 0.018, 0.022, 0.025, 0.028, 0.03]
    rough = np.array([0.4])
    stands = [0.03] * round(begins / PERIOD)
    gone = 0.03 - np.cumsum(0.0052 * np.minimum(np.arange(60) / 30, 1.0))
    arm = powered(Goes([*slid, *stands, *gone]), 5.9, inertia=(rough, rough))
    arm.enable()
    until(arm, ArmState.HOLDING)
    until(arm, ArmState.FAULT)
    assert arm.fault is not None
    assert arm.fault.kind == "following_error"
    assert arm.fault.weighed == int(told)
    assert (0 in arm.path.holding.fell) == told
