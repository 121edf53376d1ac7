"""What a URDF weighs too much bars no motion of an arm that is weighed before it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pa10d.dynamics import robot_from_profile
from pa10d.dynamics.carried import weighing
from pa10d.investigation import motions
from pa10d.profile import load_profile
from pa10d.services.starting_set import SuggestedMotion
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
