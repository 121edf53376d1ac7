"""A few short falls, each caught by the brake, tell what holds a joint."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.control.fall import Driven, Weighed
from pa10d.control.faults import LoopFault
from pa10d.control.joint_figures import ROUGH
from pa10d.control.trials import TRIALS, Caught, Trials, in_vain

PERIOD = 0.004


def fell(torque, rise):
    return Driven(torque, float(rise))


def told(least, most):
    return Weighed(0.5 * (least + most), abs(most - least), (float(least), float(most)))


def held_after(weight, inertia, presumed, rubs, thought, sign=1.0):
    """→ how many trials until friction holds the joint; None: never, or nobody knows further."""
    trials = Trials()
    for count in range(TRIALS + 1):
        lacks = sign * thought - weight
        if abs(lacks) <= rubs * (1 + 1e-9):
            return count
        rise = (lacks - np.sign(lacks) * rubs) / inertia
        ends = abs(rise) * presumed * np.array([1.0 / ROUGH, ROUGH])
        found = trials.next(fell(thought, rise), told(*(thought - np.sign(rise) * ends)))
        if found is None:
            return None
        thought = found.torque
    return None


@pytest.mark.parametrize("rubs", [0.02, 0.1])
def test_whatever_it_weighs_and_however_inert_it_is(rubs):
    """N·m, of a joint that weighs 1; thought up to three times off, as its inertia."""
    rng = np.random.default_rng(5)
    needed = []
    for _ in range(500):
        off, body = np.exp(rng.uniform(-np.log(ROUGH), np.log(ROUGH), 2))
        needed.append(held_after(1.0, 0.05 * body, 0.05, rubs, float(off)))
    assert None not in needed
    assert np.mean(needed) < 3.0


def test_a_torque_that_acts_the_wrong_way_round_is_not_raised_further():
    assert held_after(1.0, 0.05, 0.05, 0.02, 0.5, sign=-1.0) is None


def test_what_lies_between_is_tried_there():
    trials = Trials()
    assert trials.next(fell(1.0, -20.0), told(3.0, 9.0)).torque == 3.0
    assert trials.next(fell(3.0, 60.0), told(0.0, -9.0)).torque == pytest.approx(1.5)
    found = trials.next(fell(1.5, -1e-3), told(9.0, 20.0))
    assert found.between is None, "it is known well"
    assert 1.5 < found.torque < 2.0


def test_a_joint_that_weighs_otherwise_by_now_begins_anew():
    trials = Trials()
    trials.next(fell(1.0, -20.0), told(3.0, 9.0))
    assert trials.next(fell(0.5, 10.0), told(0.2, -3.0)).torque == 0.2


def test_what_a_trial_told_goes_along_to_the_next():
    """Each takes the joint on. More torque seemed to have it fall the faster, for it weighed more
    there, and nothing was tried any more."""
    trials, body = Trials(), 0.05
    assert trials.next(fell(1.9, -0.1 / body), told(2.2, 3.0), described=1.8).torque == 2.2
    found = trials.next(fell(2.2, -0.2 / body), told(2.3, 4.0), described=1.2 * 1.8)
    assert found is not None
    assert found.torque == 2.3
    found = trials.next(fell(2.3, -0.1 / body), told(2.3, 4.0), described=1.2 * 1.8)
    assert found.torque == pytest.approx(2.4)


def test_nothing_known_is_nothing_tried():
    trials = Trials()
    assert trials.next(fell(1.0, -20.0), None) is None
    assert trials.next(fell(1.0, -20.0), told(0.5, 0.1)) is None, "it would fall the faster"


def stopped(speeds, ramp=7.0):
    """The fault of a joint that fell by 8 rad/s² as its drive was to stop it."""
    caught = Caught(1, (-0.3, -8.0), 0.5, ramp)
    for speed in speeds:
        try:
            caught.watch(np.array([9.0, -speed]), PERIOD)
        except LoopFault as fault:
            return fault.kind, fault.axis
    return None


def test_a_drive_that_drives_on_what_it_shall_stop_is_told_from_a_fall():
    """The one falls on until its ramp begins, the other gets ever faster."""
    time = PERIOD * np.arange(1, 200)
    braked = np.maximum(
        0.3 + 8.0 * np.minimum(time, 0.03) - 7.0 * np.maximum(time - 0.03, 0.0), 0.0
    )
    assert stopped(braked) is None
    assert stopped((0.3 + 8.0 * time)[:40]) == ("wrong_sign", 1)
    assert stopped((0.3 + 100.0 * time)[:5]) == ("wrong_sign", 1), "before a ramp could begin"


@pytest.mark.parametrize("braked", [True, False])
def test_a_ramp_was_in_vain_once_it_had_its_time(braked):
    """Not before: what falls gathers speed until it begins."""
    caught, time = Caught(1, (-0.3, -8.0), 9.0, 7.0), PERIOD * np.arange(1, 20)
    speeds = 0.3 + 8.0 * np.minimum(time, 0.02 if braked else 1.0)
    told = []
    for speed in speeds:
        caught.watch(np.array([9.0, -speed]), PERIOD)
        told.append(caught.in_vain)
    assert any(told) != braked
    assert not any(told[: round(0.03 / PERIOD) - 1])


def test_a_drive_that_does_not_stop_it_is_named():
    assert stopped(np.append(np.linspace(0.3, 0.52, 8), np.full(200, 0.52))) == ("stop", 1)
    assert stopped(np.full(200, 0.48)) is None, "so slow a brake has it"


def test_a_joint_that_slides_on_is_held_by_more_than_its_servo_gave():
    more = in_vain(1.0, 1.2)
    assert more.between == pytest.approx((1.4, 3.0))
    assert Trials().next(fell(1.1, -0.1), more).torque == pytest.approx(1.4)
