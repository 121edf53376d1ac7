"""What a URDF weighs too much bars no motion of an arm that is weighed before it."""

from __future__ import annotations

import pytest

from pa10d.dynamics import robot_from_profile
from pa10d.dynamics.carried import weighing
from pa10d.investigation import motions
from pa10d.profile import load_profile
from pa10d.services.starting_set import SuggestedMotion

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
