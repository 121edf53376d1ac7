"""What a URDF weighs too much bars no motion of an arm that is weighed before it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.dynamics.carried import weighing
from pa10d.experiments.motion import as_lighter, whole_motion
from pa10d.investigation import begin, motions
from pa10d.profile import load_profile
from pa10d.services.starting_set import SuggestedMotion
from pa10d.trajectory.check import check
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.poses import Surroundings

FIRST = SuggestedMotion("first_motion", {}, "it measures the joints")
SWING = SuggestedMotion("tracking", {"amplitude": 0.5, "period": 4.0, "cycles": 1}, "a swing")


@pytest.mark.parametrize("question", ["missing", "changed"])
def test_torque_by_a_rough_urdf_is_no_reason_to_refuse(question, monkeypatch, tmp_path):
    profile = load_profile("pa10-sim")
    robot = robot_from_profile(profile)
    heavy = weighing(robot, 6.0 * robot.parameters)
    asked = [(SWING, "joints"), (SWING, "fit")]
    monkeypatch.setattr(motions, "_asked", lambda question, first: asked)
    seen = motions.previews(tmp_path, profile, heavy, question, lambda *_: None)
    first, later = ("; ".join(one.problems) for one in seen)
    assert "torque" in first, "nobody weighs the arm before it is measured"
    assert ("torque" in later) == (question == "changed")


@pytest.mark.parametrize(("times", "bars"), [(1.2, False), (3.5, True)])
def test_an_arm_that_its_motors_could_not_hold_is_measured_as_a_lighter_one(times, bars):
    """Motors sooner hold what they stand under than a URDF is right; three times off is no more."""
    robot = robot_from_profile(load_profile("pa10-sim")).with_gravity(np.array([9.81, 0.0, 0.0]))
    around = Surroundings.of(robot)
    load = np.abs(around.gravity(around.limits.rest_pose()[None])[0])
    weak = replace(robot, effort=np.maximum(load / 0.9 / times, 0.1 * robot.effort))
    found = motions.preview(weak, FIRST, "joints")
    assert bool(found.problems) == bars, found.problems
    if bars:
        assert "correct them where the arm is lighter" in found.problems[0]


@pytest.mark.parametrize(("times", "bars"), [(1.5, False), (6.0, True)])
def test_torque_by_a_rough_urdf_is_no_reason_not_to_measure(times, bars):
    """Held where it stands, it would take more than its motors give in another pose, or in strokes;
    not where bodies three times as light would, too."""
    robot = robot_from_profile(load_profile("pa10-sim"))
    plan, around = motions.planned(robot, "first_motion", {})
    whole = whole_motion(plan, around.limits.rest_pose(), robot, motions.LOOK)
    _, q, dq, ddq = whole.samples
    torque = np.abs(inverse_dynamics(robot, robot.parameters, q, dq, ddq)).max(axis=0)
    rest = np.abs(around.gravity(around.limits.rest_pose()[None])[0])
    weak = replace(robot, effort=np.maximum(torque / times, 1.05 * rest / 0.9))
    seen = check(whole.samples, weak, limits_of(weak), measured=around.limits.rest_pose())
    assert any(one.kind == "torque" for one in seen)
    left = as_lighter(replace(whole, violations=tuple(seen))).violations
    assert any(one.kind == "torque" for one in left) == bars


def test_an_arm_that_cannot_be_measured_is_not_investigated(monkeypatch, tmp_path):
    """Gains that follow a URDF three times off are no gains for larger motions."""

    def barred(data, profile, robot, question, progress):
        first = motions.preview(robot, FIRST, "joints")
        swing = motions.preview(robot, SWING, "fit")
        return [replace(first, problems=("joint 2 meets the floor",)), swing]

    monkeypatch.setattr(begin, "previews", barred)
    with pytest.raises(UserError, match=r"measures the joints.*joint 2 meets the floor"):
        begin.begin(str(tmp_path), "pa10-sim")
    assert not list(tmp_path.glob("investigations/*/state.json"))
