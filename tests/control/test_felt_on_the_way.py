"""What an arm weighs is learnt from motions that were not the first one's, or not its whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pa10d.control.faults import Fault
from pa10d.control.joint_figures import first_figures
from pa10d.control.known_joints import MeasuredJoints
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.dynamics.carried import carrying, weighing
from pa10d.experiments.measured_joints import felt_again
from pa10d.experiments.seen import Seen
from pa10d.profile import load_profile
from pa10d.services import experiments
from pa10d.services.joints import begun, learnt, weighed
from pa10d.trajectory.capsules import capsules_of
from pa10d.trajectory.plan import Plan

RATE, WRIST = 100.0, 5  # Hz, 0-based
FELL = Fault("following_error", "is 0.15 rad from where it should be", axis=WRIST, was_there=True)


@pytest.fixture(scope="module")
def arm():
    profile = load_profile("pa10-sim")
    profile = profile.model_copy(
        update={"control": profile.control.model_copy(update={"rate": RATE})}
    )
    robot = robot_from_profile(profile)
    known, _ = begun(profile, robot, first_figures(robot, np.zeros((2, robot.n))))
    return profile, robot, known


def nudged(robot, heavier, rubs, seconds=10.0, size=0.06):
    """All joints to and fro about zero, their wrist ``heavier`` than the URDF says."""
    t = np.arange(round(seconds * RATE)) / RATE
    w = 0.6 * np.linspace(1.0, 1.6, robot.n)
    q, dq, ddq = (
        size * np.sin(np.outer(t, w)),
        size * w * np.cos(np.outer(t, w)),
        -size * w**2 * np.sin(np.outer(t, w)),
    )
    bodies = robot.parameters * np.where(np.arange(robot.n) < WRIST, 1.0, heavier)[:, None]
    torque = inverse_dynamics(robot, bodies, q, dq, ddq) + rubs * np.sign(dq)
    return Seen(Plan("first_motion", (1,), ()), RATE, q, torque), bodies


def holds(robot, bodies, q):
    return inverse_dynamics(robot, bodies, q[None], 0 * q[None], 0 * q[None])[0]


@pytest.mark.long
def test_a_joint_that_fell_behind_by_its_weight_is_weighed_by_what_was_recorded(arm):
    profile, robot, known = arm
    seen, true = nudged(robot, 2.9, rubs=0.0)
    lean = 0.3 * np.ones(robot.n)
    found = weighed(profile, robot, known, FELL, seen)
    wrong = holds(robot, robot.parameters, lean)[WRIST] - holds(robot, true, lean)[WRIST]
    left = holds(robot, found.known.felt, lean)[WRIST] - holds(robot, true, lean)[WRIST]
    assert abs(left) < 0.4 * abs(wrong)
    assert "joint 6 fell behind" in found.note
    assert "more or less than its URDF says" in found.note
    assert found.known.gains.kp[WRIST] > known.gains.kp[WRIST]


def test_not_where_its_weight_does_not_explain_it_nor_where_it_may_have_met_something(arm):
    profile, robot, known = arm
    right, _ = nudged(robot, 1.0, rubs=0.0)
    heavy, _ = nudged(robot, 2.9, rubs=0.0)
    stuck = replace(heavy, q=0.02 * heavy.q, torque=holds(robot, robot.parameters, heavy.q[0]) * 1.0
                    + 5.0 * np.sin(np.arange(len(heavy.q)) / 99.0)[:, None])  # fmt: skip
    assert weighed(profile, robot, known, FELL, right) is None
    assert weighed(profile, robot, known, FELL, stuck) is None, "friction that held it is no weight"
    pressed = replace(known, gains=replace(known.gains, kp=1e3 * known.gains.kp))
    met = replace(FELL, was_there=False)
    assert weighed(profile, robot, pressed, met, heavy) is None


def test_more_motions_leave_less_doubt(arm):
    _, robot, known = arm
    near, true = nudged(robot, 1.5, 0.0, size=0.02)
    far, _ = nudged(robot, 1.5, 0.0, size=0.5)
    lean = 0.8 * np.ones(robot.n)

    def doubt(more):
        felt = felt_again(robot, known.figures, {"friction": near}, more)
        weights = np.array([holds(robot, bodies, lean) for bodies in felt.bodies])
        return np.ptp(weights, axis=0)[WRIST], abs(weights[0] - holds(robot, true, lean))[WRIST]

    before, after = doubt([]), doubt([far])
    assert after[0] < 0.5 * before[0]
    assert after[1] < 0.5 * before[1]


@pytest.mark.parametrize("weight", [None, 2.0])
def test_shapes_are_the_urdfs_whatever_bodies_weigh(arm, weight):
    """A plan that was free by thinner bodies was refused by the pre-check, which has the URDF's."""
    _, robot, _ = arm
    felt = robot.parameters * np.linspace(0.4, 2.0, robot.n)[:, None]
    felt[:, 4:] *= 0.5
    felt[-1, 1:4] *= 1.5
    bare, felt_robot = robot, weighing(robot, felt)
    if weight is not None:
        bare, felt_robot = (carrying(r, weight, np.array([0, 0, 0.1])) for r in (robot, felt_robot))
    known, planned = capsules_of(bare), capsules_of(felt_robot)
    for one in ("start", "end", "radius", "pairs"):
        assert np.array_equal(getattr(known, one), getattr(planned, one))
    assert np.array_equal(weighing(robot, felt).parameters, felt)


def test_plans_of_a_measured_arm_keep_its_shapes(arm, monkeypatch):
    profile, robot, known = arm
    felt = known.figures.but(bodies=np.stack(2 * [0.5 * robot.parameters]))
    kept = MeasuredJoints(learnt(profile, robot, felt), "", (), "pa10", "f")
    monkeypatch.setattr(experiments, "kept_joints", lambda *_: kept)
    planned = experiments.weighed_arm(None, profile, robot)
    assert np.array_equal(planned.parameters, 0.5 * robot.parameters)
    assert planned.bare is robot
