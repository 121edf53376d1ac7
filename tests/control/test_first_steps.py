"""A first motion's first steps: a wrong sign is named before its joint has gone far."""

from __future__ import annotations

import numpy as np
import pytest
from arm_bench import ArmBench

from pa10d.control.faults import LoopFault
from pa10d.control.first_steps import FirstSteps
from pa10d.control.reference import Reference


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


def leaning(others, rubs=0.08, inertia=0.02, period=0.003):
    """A joint is asked to go down by 0.04 rad while weight comes off it; it comes up against its
    friction, its torque less downwards than it was at rest. others: by how much the one that
    carries it is asked to lean meanwhile, rad → how far it went the other way, rad."""
    watch, wanted = FirstSteps(np.array([50.0, 5.0]), period), Reference(2)
    q, v, torque, farthest = -0.02, 0.0, -0.14, 0.0
    for k in range(round(1.0 / period)):
        s = min(max(k * period - 0.05, 0.0), 1.0)
        way = np.array([others, -0.04])
        wanted.q[:] = way * (10 * s**3 - 15 * s**4 + 6 * s**5)
        wanted.dq[:] = way * 30 * (s**2 - 2 * s**3 + s**4)
        at, speed = np.array([wanted.q[0], q]), np.array([wanted.dq[0], v])
        watch.watch(at, speed, np.array([0.0, torque]), wanted)
        torque = -0.14 - 0.3 * s + 4.0 * (wanted.q[1] - q - 0.02) + 0.3 * (wanted.dq[1] - v)
        free = v + period * (torque + 0.14 + 0.8 * s) / inertia
        v = np.sign(free) * max(abs(free) - period * rubs / inertia, 0.0)
        q += period * v
        farthest = max(farthest, q - wanted.q[1])
    return farthest


def test_a_joint_whose_weight_others_lean_away_has_no_wrong_sign():
    """Its own step it takes alone."""
    assert leaning(-0.04) > 0.05
    with pytest.raises(LoopFault, match="wrong way round"):
        leaning(0.0)
