"""Plans, their check, and ways around what is in the way."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.daemon.check import environment_checks
from pa10d.profile import find_profile
from pa10d.services.robots import load_robot
from pa10d.trajectory.check import check
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.motions import Drawing, MotionSamples
from pa10d.trajectory.plan import Plan, Segment, joined, move
from pa10d.trajectory.poses import Surroundings, gravity_free_pose
from pa10d.trajectory.ways import free_way, way_is_free
from tests.trajectory.sample_arms import among, around_pa10, box, pa10

LIMITS = limits_of(pa10())


def swing(joint, angle, seconds):
    strokes = Drawing(np.zeros(7))
    there = np.zeros(7)
    there[joint] = angle
    strokes.to(there, seconds)
    return strokes.knots()


def plan_of(*motions):
    segments = [Segment(motion, f"part {k + 1}") for k, motion in enumerate(motions)]
    return joined("test", [0], segments, around_pa10())


def kinds(violations):
    return [(v.kind, v.joint) for v in violations]


def test_segments_are_joined_without_a_jump():
    plan = plan_of(swing(0, 0.5, 2.0), swing(2, -1.0, 3.0))
    assert [s.label for s in plan.segments] == ["part 1", "", "part 2"]
    assert [span.label for span in plan.spans] == ["part 1", "part 2"]
    samples = plan.sample(500.0)
    assert np.abs(np.diff(samples.q, axis=0)).max() < 0.01
    assert check(plan, pa10(), LIMITS) == []
    again = Plan.from_dict(json.loads(json.dumps(plan.to_dict())))
    assert np.array_equal(again.sample(100.0).q, plan.sample(100.0).q)
    assert again.spans == plan.spans


def test_too_fast_too_far_too_strong_each_say_joint_time_value_and_limit():
    fast = check(plan_of(swing(1, 1.5, 1.0)), pa10(), LIMITS)
    speed = next(v for v in fast if v.kind == "velocity")
    assert (speed.joint, speed.limit) == (2, 1.0)
    assert speed.time == pytest.approx(0.5, abs=0.01)
    assert abs(speed.value) == pytest.approx(1.875 * 1.5, rel=1e-3)
    assert "joint 2 at 0.50 s: speed 2.8" in speed.sentence
    assert "limit of 1 rad/s" in speed.sentence
    far = check(plan_of(swing(1, 1.7, 8.0)), pa10(), LIMITS)
    assert ("position", 2) in kinds(far)
    weak = replace(LIMITS, torque=np.array([232.0, 40.0, 100, 100, 14.5, 14.5, 14.5]))
    assert ("torque", 2) in kinds(check(plan_of(swing(1, 1.4, 8.0)), pa10(), weak))


def test_braking_distance_counts():
    """At 1 rad/s and 3 rad/s² a joint stops after 1/6 rad: full speed 0.1 rad before the limit is
    too late although no position is beyond it."""
    upper = float(LIMITS.upper[0])
    t = np.arange(0.0, 1.0, 0.005)
    q, dq = np.zeros((len(t), 7)), np.zeros((len(t), 7))
    q[:, 0] = upper - 0.1 - (t[-1] - t)
    dq[:, 0] = 1.0
    found = check(MotionSamples(t, q, dq, np.zeros_like(q)), pa10(), LIMITS)
    first = next(v for v in found if v.kind == "position")
    assert first.value == pytest.approx(upper - 0.1 + 1 / 6, abs=1e-6)
    assert "braking included" in first.sentence
    q[:, 0] -= 0.1
    assert "position" not in [v.kind for v in check(MotionSamples(t, q, dq, 0 * q), pa10(), LIMITS)]


def test_collisions_jumps_rest_and_start_are_seen():
    down = Drawing(np.zeros(7))
    there = np.zeros(7)
    there[1], there[3] = 1.5, 1.5
    down.to(there, 8.0)
    plan = Plan("test", (2,), (Segment(down.knots(), "down"),))
    meets = check(plan, pa10(), LIMITS)
    assert kinds(meets) == [("collision", 0)] * len(meets)
    assert any("floor" in v.sentence for v in meets)
    samples = plan_of(swing(0, 0.5, 2.0)).sample(200.0)
    torn = samples._replace(q=samples.q + 0.2 * (samples.t > 1.0)[:, None])
    assert ("step", 1) in kinds(check(torn, pa10(), LIMITS))
    half = MotionSamples(*(part[:200] for part in samples))
    assert ("rest", 1) in kinds(check(half, pa10(), LIMITS))
    away = check(samples, pa10(), LIMITS, measured=np.array([0.3] + [0.0] * 6))
    assert kinds(away) == [("start", 1)]
    nan = samples._replace(dq=np.where(samples.t[:, None] > 1, np.nan, samples.dq))
    assert kinds(check(nan, pa10(), LIMITS)) == [("number", 1)]
    assert kinds(
        check(MotionSamples(samples.t, *(x[:, :3] for x in samples[1:])), pa10(), LIMITS)
    ) == [("shape", 0)]


def test_a_way_around_the_shoulder_is_found():
    around = around_pa10()
    here, there = np.zeros(7), np.zeros(7)
    here[[1, 3]] = 1.45, 0.35  # stretched out low in front, low behind
    there[[1, 3]] = -1.45, -0.35
    here[0], there[0] = 0.0, 0.4
    straight = way_is_free(around, here, there)
    way = [here, *free_way(around, here, there)]
    assert np.array_equal(way[-1], there)
    assert straight or len(way) > 2
    for a, b in pairwise(way):
        poses = a + np.linspace(0, 1, 400)[:, None] * (b - a)
        assert around.capsules.clearance(poses).min() > 0.02
    assert free_way(around, here, here) == []


def test_an_obstacle_in_the_straight_way_is_gone_around():
    around = Surroundings.of(among(pa10(), floor=0.18))  # not far below the shoulder
    rng, blocked = np.random.default_rng(0), 0
    for _ in range(400):
        here, there = (around.random_pose(rng, 0.95) for _ in range(2))
        if way_is_free(around, here, there):
            continue
        blocked += 1
        way = [here, *free_way(around, here, there)]
        assert len(way) > 2
        assert all(way_is_free(around, a, b) for a, b in pairwise(way))
    assert blocked > 3


def test_no_way_leads_into_the_floor():
    there = np.zeros(7)
    there[1], there[3] = 1.5, 1.5
    with pytest.raises(UserError, match="no way leads there"):
        free_way(around_pa10(), np.zeros(7), there)


def test_an_arm_that_stands_outside_of_its_limits_is_told_so():
    here = np.zeros(7)
    here[1] = 18.75
    with pytest.raises(UserError, match=r"joint 2 at 18\.7500 rad is outside of its limits"):
        free_way(around_pa10(), here, np.full(7, 0.1))


def test_moves_are_gentle():
    way = move(np.zeros(7), np.full(7, 0.8), LIMITS).sample(1000.0)
    assert np.all(np.abs(way.dq).max(axis=0) <= 0.5 * LIMITS.velocity * (1 + 1e-6))
    assert np.all(np.abs(way.ddq).max(axis=0) <= 0.5 * LIMITS.acceleration * (1 + 1e-6))


@pytest.mark.parametrize("joint", range(7))
def test_gravity_free_poses_are_free_of_gravity(joint):
    around = around_pa10()
    found = gravity_free_pose(around, joint, 0.5)
    poses = np.tile(found.pose, (21, 1))
    poses[:, joint] += np.linspace(-0.5, 0.5, 21)
    assert around.allowed(poses).all()
    torque = np.abs(around.gravity(poses)[:, joint]).max()
    if joint == 1:  # its axis is horizontal in every pose
        assert not found.free
        assert torque > 1.0
    else:
        assert found.free
        assert torque < 1.0


def test_a_box_is_kept_clear_of_and_gone_around():
    here, there = np.zeros(7), np.zeros(7)
    here[[0, 1]], there[[0, 1]] = (-0.9, 1.1), (0.9, 1.1)
    free, blocked = pa10(), among(pa10(), box((0.3, 0.3, 2.0), (0.75, 0.0, 1.0)))
    straight = plan_of(move(here, there, LIMITS))
    assert check(straight, free, LIMITS) == []
    (found,) = [v for v in check(straight, blocked, LIMITS) if "'table'" in v.sentence][:1]
    assert found.kind == "collision"
    places = Surroundings.of(blocked)
    assert not way_is_free(places, here, there)
    way = [here, *free_way(places, here, there)]
    assert len(way) > 2
    assert all(way_is_free(places, a, b) for a, b in pairwise(way))


def test_without_a_floor_the_arm_may_hang_down():
    low = np.zeros(7)
    low[[1, 3]] = 1.5, 0.9
    assert not Surroundings.of(pa10()).allowed(low[None])[0]
    assert Surroundings.of(among(pa10(), floor=None)).capsules.clearance(low[None]).min() > 0.03


def test_a_profile_says_what_stands_around_and_everybody_is_told(tmp_path):
    text = (
        find_profile("pa10-sim")
        .read_text()
        .replace("urdf: ", f"urdf: {find_profile('pa10-sim').parent}/")
    )
    text = text.replace("floor: 0 ", "floor: none ").replace(
        "boxes: []", "boxes: [{size: [1, 1, 1], xyz: [0, 0, 1]}]"
    )
    (tmp_path / "arm.yaml").write_text(text)
    robot = load_robot(tmp_path / "arm.yaml")[1]
    assert str(robot.environment) == "'box 1'"
    assert str(pa10().environment) == "the floor at 0 m"
    found = environment_checks(robot)
    assert {check.level for check in found} == {"warning"}, "at rest the arm stands in the box"
    assert "'box 1'" in found[0].sentence
    assert [check.level for check in environment_checks(pa10())] == ["ok"]


def test_of_a_slide_it_is_said_in_metres_and_newtons():
    """A lift was refused for so many N·m."""
    robot = pa10()
    slides = replace(robot, prismatic=np.arange(7) == 1)
    one, t = np.ones((1, 7)), np.arange(0.0, 1.0, 0.01)
    fast = MotionSamples(
        t, 9.0 * t[:, None] * one, 9.0 + 0.0 * t[:, None] * one, 900.0 * t[:, None] * one
    )
    for arm, unit, others in ((robot, "N·m", "rad"), (slides, "N", "m")):
        said = [one.sentence for one in check(fast, arm, LIMITS) if one.joint == 2]
        assert any("torque " in text and text.endswith(f" {unit}") for text in said)
        assert any(f" {others}/s²" in text for text in said)
        assert any("rad" in text for text in said) == (others == "rad")
