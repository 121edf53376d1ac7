"""What a joint passed freely does not bar its way back; what lies beyond may."""

from __future__ import annotations

import numpy as np
import pytest
from arm_bench import ArmBench
from hypothesis import given
from hypothesis import strategies as st

from pa10d.control.faults import Fault
from pa10d.control.places import CLEARLY, Places

ANGLES = st.floats(-2.0, 2.0)


@given(path=st.lists(ANGLES, min_size=1, max_size=20), wanted=ANGLES)
def test_only_what_was_passed_counts(path, wanted):
    places = Places(np.full(1, 0.15))
    places.restart(np.full(1, path[0]))
    for q in path:
        places.see(np.full(1, q))
    now = path[-1]
    further = [(q - now) * np.sign(wanted - now) for q in path]
    was_there = places.towards(np.full(1, wanted), np.full(1, now), 0)
    assert was_there == (wanted != now and max(further) > CLEARLY * 0.15) or wanted == now


def test_power_up_forgets_the_past():
    places = Places(np.full(1, 0.15))
    for q in (0.0, 1.0):
        places.see(np.full(1, q))
    places.restart(np.full(1, 1.0))
    assert not places.towards(np.zeros(1), np.full(1, 1.0), 0)


@pytest.mark.parametrize("came_from_there", [True, False])
def test_a_fault_says_whether_its_joint_had_been_where_it_should_go(came_from_there):
    """The last joint is taken away from where it is held; or its place is, and it is held fast."""
    arm = ArmBench(250.0, pose=[0, 0.3, 0, 0.4, 0, 0.2, 0])
    assert arm.enable() is None
    for k in range(500):
        if came_from_there:
            arm.backend.plant.q[6] = 0.001 * k
        else:
            arm.backend.plant.q[6] = 0.0
            arm.arm.path.reference.q[6] = 0.001 * k
        arm.arm.cycle()
        if arm.arm.fault is not None:
            break
    fault = arm.arm.fault
    assert (fault.kind, fault.joint) == ("following_error", 7)
    assert fault.was_there is came_from_there
    assert Fault.from_document(fault.document()) == fault
