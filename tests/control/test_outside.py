"""An arm that stands outside its position limits: powered only where that is asked for, and from
there it goes inward, slowly, or not at all."""

from __future__ import annotations

import numpy as np
import pytest
from arms import PERIOD, cycles, flywheel_arm, limits, swing, until, way_in

from pa10d.control.commands import Commands
from pa10d.control.envelope import OVERSHOOT
from pa10d.control.outside import FARTHEST, Reach
from pa10d.control.reference import MotionUnderWay
from pa10d.control.states import ArmState, Refused

UPPER = limits().upper[0]


def arm_at(*q):
    """Connected and unpowered, at q rad."""
    arm, backend = flywheel_arm(len(q))
    backend.plant.reset(np.array(q))
    arm.connect()
    cycles(arm, 3)
    return arm, backend


def recovered(*q):
    """Powered there all the same, and held."""
    arm, backend = arm_at(*q)
    arm.enable(recover=True)
    until(arm, ArmState.HOLDING)
    return arm, backend


def refusal(do, *arguments, **more) -> str:
    with pytest.raises(Refused) as refused:
        do(*arguments, **more)
    return str(refused.value)


def test_power_is_refused_with_where_and_how_to_get_back():
    arm, backend = arm_at(0.3, UPPER + 0.05)
    assert refusal(arm.enable) == (
        "enable: joint 2 stands 0.0500 rad beyond its upper limit of 2.0000 rad: ask for 'recover' "
        "to bring it back slowly, move it inside by hand, or correct its zero_offset"
    )
    assert not backend.powered
    assert arm.state == ArmState.INACTIVE


def test_asked_for_it_is_powered_and_comes_back_to_the_ordinary_limits():
    arm, backend = recovered(0.3, UPPER + 0.05)
    arm.run(way_in(arm.path.reference.q, [0.3, UPPER - 0.03]))
    until(arm, ArmState.HOLDING)
    assert arm.fault is None
    assert backend.plant.q[1] < UPPER
    arm.run(swing(arm.path.reference.q, -1.0))  # at full speed again
    until(arm, ArmState.HOLDING)
    assert arm.fault is None
    outward = way_in(arm.path.reference.q, [0.3, UPPER + 0.01])
    assert "beyond its upper limit" in refusal(arm.run, outward)
    arm.disable()
    until(arm, ArmState.INACTIVE)
    arm.enable()  # … without being asked for anything


def test_the_field_of_the_command_reaches_the_arm():
    arm, _ = arm_at(UPPER + 0.05, 0.0)
    commands = Commands(arm, None, None)
    answer = commands.carry_out({"id": 1, "do": "enable"})
    assert not answer["ok"]
    assert "recover" in answer["remedy"]
    assert commands.carry_out({"id": 2, "do": "enable", "recover": True})["ok"]


def test_further_out_it_is_not_powered_whatever_is_asked():
    arm, backend = arm_at(-UPPER - FARTHEST - 0.01, UPPER + 0.05)
    said = refusal(arm.enable, recover=True)
    assert "joint 1 is more than the 0.2 rad from which it may be powered" in said
    assert "by hand" in said
    assert "recover'" not in said
    assert not backend.powered


@pytest.mark.parametrize(
    ("ends", "share", "says"),
    [
        ([0.0, UPPER + 0.06], 0.9, "leaves it outside"),
        ([0.0, UPPER + 0.02], 0.9, "leaves it outside"),
        ([1.0, UPPER + 0.05], 0.9, "leaves it outside"),  # of another joint only
        ([0.0, UPPER - 0.03], 1.2, "until it is inside 0.2 rad/s are allowed"),
        ([-0.9, UPPER - 0.03], 1.2, "joint 1 moves"),  # nor is another one fast meanwhile
    ],
)
def test_plans_that_do_not_lead_inward_slowly_are_refused(ends, share, says):
    arm, _ = recovered(0.0, UPPER + 0.05)
    assert says in refusal(arm.run, way_in(arm.path.reference.q, ends, share))
    assert arm.state == ArmState.HOLDING


def test_a_plan_that_goes_a_little_outward_before_it_goes_in_is_refused():
    arm, _ = recovered(0.0, UPPER + 0.05)
    out, back = UPPER + 0.0515, UPPER - 0.03
    there = way_in(arm.path.reference.q, [0.0, out])
    rows = np.vstack([there.rows, way_in([0.0, out], [0.0, back]).rows])
    assert "turns it outward" in refusal(arm.run, MotionUnderWay(1, rows))


def test_once_inside_a_plan_may_not_leave_again():
    arm, _ = recovered(0.0, UPPER + 0.05)
    back, out = UPPER - 0.01, UPPER + 0.02
    inward = way_in(arm.path.reference.q, [0.0, back])
    rows = np.vstack([inward.rows, way_in([0.0, back], [0.0, out]).rows])
    assert "beyond its limit once more" in refusal(arm.run, MotionUnderWay(1, rows))


def pushed(arm, backend, end):
    """Joint 2 slowly to ``end`` rad, whatever its servo does about it."""
    while arm.fault is None and backend.plant.q[1] < end:
        backend.plant.q[1] += 0.1 * limits().velocity[1] * PERIOD
        backend.plant.dq[1] = 0.0
        arm.cycle()


def test_a_push_outward_ends_it():
    arm, backend = recovered(0.0, UPPER + 0.05)
    pushed(arm, backend, UPPER + 0.05 + 0.9 * OVERSHOOT)
    assert arm.fault is None
    pushed(arm, backend, UPPER + 0.05 + 1.1 * OVERSHOOT)
    until(arm, ArmState.FAULT)
    assert arm.fault.kind == "position_limit"
    assert arm.fault.axis == 1
    assert not backend.powered


def test_what_it_has_come_inward_is_not_given_back():
    """Half way in, a push to where it began is beyond the limit that it has by then."""
    arm, backend = recovered(0.0, UPPER + 0.05)
    arm.run(way_in(arm.path.reference.q, [0.0, UPPER - 0.03]))
    while backend.plant.q[1] > UPPER + 0.02:
        arm.cycle()
    pushed(arm, backend, UPPER + 0.05)
    until(arm, ArmState.FAULT)
    assert arm.fault.kind == "position_limit"


def test_a_stop_on_the_way_holds_it_and_another_plan_brings_it_in():
    arm, backend = recovered(0.0, UPPER + 0.15)
    arm.run(way_in(arm.path.reference.q, [0.0, UPPER - 0.03]))
    cycles(arm, 300)
    arm.stop()
    until(arm, ArmState.HOLDING)
    assert UPPER < backend.plant.q[1] < UPPER + 0.15
    arm.run(way_in(arm.path.reference.q, [0.0, UPPER - 0.03]))
    until(arm, ArmState.HOLDING)
    assert arm.fault is None
    assert backend.plant.q[1] < UPPER


def test_no_joint_is_fast_while_one_is_outside():
    """The speed that is watched is that of an arm that shall stand."""
    arm, backend = recovered(0.0, UPPER + 0.05)
    backend.plant.dq[0] = 0.5 * limits().velocity[0]
    until(arm, ArmState.FAULT)
    assert arm.fault.kind == "velocity_limit"
    assert arm.fault.axis == 0


def test_the_reach_follows_inward_only():
    reach, low, high = Reach(limits()), -UPPER, UPPER
    reach.begin(np.array([0.0, high + 0.1]))
    for q, upper in ((0.05, 0.05), (0.08, 0.05), (0.02, 0.02), (-0.5, 0.0), (0.1, 0.0)):
        reach.follow(np.array([0.0, high + q]))
        assert reach.upper == pytest.approx([high, high + upper])
    assert not reach.widened
    assert reach.lower == pytest.approx([low, low])
