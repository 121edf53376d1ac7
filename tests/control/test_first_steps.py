"""A first motion's first steps: crossed motor cables and wrong signs are named before a joint has
gone far, by the arm's own torques."""

from __future__ import annotations

import numpy as np
import pytest
from arm_bench import ArmBench


def wired(rate, drives=None, signs=None, **plant):
    """An arm whose drive ``drives[k]`` is asked as drive k, with torques of these signs; each
    measures its own joint."""
    arm = ArmBench(rate, **plant)
    turns = np.arange(arm.robot.n) if drives is None else np.array(drives) - 1
    signs = np.ones(arm.robot.n) if signs is None else np.array(signs)
    step = arm.plant.step
    arm.plant.step = lambda torque, dt: step((signs * torque)[turns], dt)
    return arm


def travelled(arm):
    """rad, the farthest that any joint went in all that was recorded."""
    rows, _ = arm.ring.read(0)
    return np.ptp(arm.ring.layout.get(rows, "q"), axis=0).max()


CROSSED = {
    "shoulder": (500.0, (3, 2, 1, 4, 5, 6, 7), 1, 3),
    "elbow": (250.0, (1, 4, 3, 2, 5, 6, 7), 2, 4),
    "wrist": (250.0, (1, 2, 3, 4, 6, 5, 7), 5, 6),
    "flange": (125.0, (1, 2, 3, 4, 5, 7, 6), 6, 7),
    "round about": (250.0, (3, 1, 2, 4, 5, 6, 7), 1, 2),
}


@pytest.mark.parametrize("name", CROSSED)
def test_cables_that_are_swapped_are_named_within_a_tenth_of_a_radian(name):
    rate, drives, pushed, moved = CROSSED[name]
    arm = wired(rate, drives)
    fault = arm.first_motion()
    assert (fault.kind, fault.joint) == ("crossed", moved)
    assert f"pushing joint {pushed} moves joint {moved}" in fault.sentence
    assert fault.runs_away  # no servo of ours brakes a joint that it does not move
    assert travelled(arm) < 0.1


@pytest.mark.parametrize(
    ("joint", "rate", "rubs"),
    [(2, 500.0, 0.0), (3, 100.0, 3.0), (4, 250.0, 1.0), (5, 125.0, 0.0), (6, 250.0, 1.0)],
)
def test_a_sign_that_friction_hid_is_named_in_the_first_step(joint, rate, rubs):
    signs = np.ones(7)
    signs[joint - 1] = -1.0
    arm = wired(rate, signs=signs, friction=rubs * np.ones(7))
    fault = arm.first_motion()
    assert (fault.kind, fault.joint) == ("wrong_sign", joint)
    assert arm.notes == []  # nor was it tried with firmer gains before
    assert travelled(arm) < 0.1
