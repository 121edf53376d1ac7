"""What is left to limits, floor and itself, against poses that Pinocchio computes."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from pa10d.experiments.margins import margins, poses_of
from pa10d.experiments.motion import whole_motion
from pa10d.services.robots import load_robot
from pa10d.trajectory.capsules import capsules_of
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.poses import Surroundings


@pytest.fixture(scope="module")
def planned():
    robot = load_robot("pa10-sim")[1]
    asked = read_request({"kind": "point_to_point", "parameters": {}})
    plan = asked.build(Surroundings.of(robot))
    whole = whole_motion(plan, np.zeros(robot.n), robot, 100.0)
    return robot, whole


def test_margins_of_joints_are_those_of_the_samples(planned):
    robot, whole = planned
    limits, (t, q, dq, _ddq) = limits_of(robot), whole.samples
    torque = np.ones_like(q)
    found = margins(whole, torque, limits, capsules_of(robot))
    for j, one in enumerate(found.joints):
        brake = [v * abs(v) / (2 * limits.acceleration[j]) for v in dq[:, j]]
        rest = [x + b for x, b in zip(q[:, j], brake, strict=True)]
        left = [min(limits.upper[j] - x, x - limits.lower[j]) for x in rest]
        assert one.joint == j + 1
        assert one.position == pytest.approx(min(left))
        assert one.at == pytest.approx(t[int(np.argmin(left))])
        assert one.velocity == pytest.approx(max(abs(dq[:, j])) / limits.velocity[j])
        assert one.torque == pytest.approx(1.0 / limits.torque[j])


def test_the_floor_is_as_far_as_the_lowest_point_of_any_body(planned):
    robot, whole = planned
    bodies = capsules_of(robot)
    found = margins(whole, np.zeros_like(whole.samples.q), limits_of(robot), bodies)
    model, index = robot.pinocchio()
    data, lowest = model.createData(), np.inf
    for q in whole.samples.q:
        own = np.empty(robot.n)
        own[:] = q[index]
        pin.forwardKinematics(model, data, own)
        for c in bodies.grounded:
            place = data.oMi[int(np.flatnonzero(index == bodies.link[c])[0]) + 1]
            for end in (bodies.start[c], bodies.end[c]):
                lowest = min(
                    lowest, (place.rotation @ end + place.translation)[2] - bodies.radius[c]
                )
    assert found.floor.margin == pytest.approx(lowest, abs=1e-9)
    assert "the floor" in found.floor.between


def test_a_preview_is_short_and_keeps_the_time(planned):
    whole = planned[1]
    seen = poses_of(whole)
    t, q = whole.samples.t, whole.samples.q
    assert len(seen.poses) <= 600
    k = len(seen.poses) // 2
    at = round(k * seen.dt / (t[1] - t[0]))
    assert np.allclose(seen.poses[k], q[at], atol=1e-4)
    assert 0 < seen.begins < seen.ends <= seen.seconds
