"""A first motion's first steps: a wrong sign is named before its joint has gone far."""

from __future__ import annotations

import numpy as np
import pytest
from arm_bench import ArmBench


def wired(rate, signs, **plant):
    """An arm whose drives turn its motors with these signs."""
    arm = ArmBench(rate, **plant)
    step = arm.plant.step
    arm.plant.step = lambda torque, dt: step(signs * torque, dt)
    return arm


def travelled(arm):
    """rad, the farthest that any joint went in all that was recorded."""
    rows, _ = arm.ring.read(0)
    return np.ptp(arm.ring.layout.get(rows, "q"), axis=0).max()


@pytest.mark.parametrize(
    ("joint", "rate", "rubs"),
    [(2, 500.0, 0.0), (3, 100.0, 3.0), (4, 250.0, 1.0), (1, 250.0, 1.0), (6, 250.0, 1.0)],
)
def test_a_sign_that_friction_hid_is_named_in_the_first_step(joint, rate, rubs):
    signs = np.ones(7)
    signs[joint - 1] = -1.0
    arm = wired(rate, signs, friction=rubs * np.ones(7))
    fault = arm.first_motion()
    assert (fault.kind, fault.joint) == ("wrong_sign", joint)
    assert arm.notes == []  # nor was it tried with firmer gains before
    assert travelled(arm) < 0.1
