"""Distances between capsules against a collision library, and what counts as a body."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.dynamics import robot_from_urdf
from pa10d.trajectory.capsules import capsules_of
from tests.trajectory.sample_arms import among, box, pa10


def frames(robot, q):
    """Rotation and origin of every joint, by Pinocchio."""
    import pinocchio as pin

    model, index = robot.pinocchio()
    data = model.createData()
    pin.forwardKinematics(model, data, q[index])
    places = [None] * robot.n
    for i, j in enumerate(index):
        places[j] = (data.oMi[i + 1].rotation, data.oMi[i + 1].translation)
    return places


def as_coal(coal, capsules, k, ends):
    """A capsule and where it is."""
    low, high = ends[k]
    along = (high - low) / np.linalg.norm(high - low)
    side = np.linalg.svd(along[None])[2]
    turn = np.column_stack([side[1], np.cross(along, side[1]), along])
    body = coal.Capsule(capsules.radius[k], float(np.linalg.norm(high - low)))
    return body, coal.Transform3s(turn, 0.5 * (low + high))


def test_clearances_are_those_of_a_collision_library():
    coal = pytest.importorskip("coal", reason="the collision library coal is not installed")
    boxes = [box((0.5, 0.3, 0.8), (0.7, -0.3, 0.6), 0.9), box((0.2, 2.0, 0.1), (-0.5, 0.0, 0.9))]
    robot = among(pa10(), *boxes)
    capsules = capsules_of(robot)
    q = np.random.default_rng(4).uniform(-2, 2, (40, 7))
    found = capsules.clearance(q)
    for sample in range(40):
        places = [*frames(robot, q[sample]), (np.eye(3), np.zeros(3))]  # the last one: the base
        ends = []
        for link, start, end in zip(capsules.link, capsules.start, capsules.end, strict=True):
            turn, origin = places[link]
            ends.append((turn @ start + origin, turn @ end + origin))
        for column, (a, b) in enumerate(capsules.pairs):
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            shapes = [part for k in (a, b) for part in as_coal(coal, capsules, k, ends)]
            gap = coal.distance(*shapes, request, result)
            if gap > 0:
                assert found[sample, column] == pytest.approx(gap, abs=1e-5)
        for column, k in enumerate(capsules.grounded):
            low = min(ends[k][0][2], ends[k][1][2]) - capsules.radius[k]
            assert found[sample, len(capsules.pairs) + column] == pytest.approx(low, abs=1e-9)
        before = len(capsules.pairs) + len(capsules.grounded)
        for column, (k, b) in enumerate(capsules.blocked):
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            solid = coal.Box(*boxes[b].size), coal.Transform3s(boxes[b].rotation, boxes[b].position)
            gap = coal.distance(*as_coal(coal, capsules, k, ends), *solid, request, result)
            if gap > 0:
                assert found[sample, before + column] == pytest.approx(gap, abs=1e-5)
            else:
                assert found[sample, before + column] < 1e-5


def test_straight_up_is_free_and_folded_down_is_not():
    capsules = capsules_of(pa10())
    straight, folded = np.zeros(7), np.zeros(7)
    folded[1], folded[3] = 1.5, 1.5
    gaps = capsules.clearance(np.array([straight, folded]))
    assert gaps[0].min() > 0.1
    assert gaps[1].min() < 0
    assert "the floor" in capsules.name(int(np.argmin(gaps[1])))


def test_neighbours_never_collide_and_the_floor_can_be_taken_away():
    robot = pa10()
    capsules = capsules_of(robot)
    links = [tuple(capsules.link[pair]) for pair in capsules.pairs]
    assert (0, 2) not in links  # upper arm stands on the shoulder
    assert (0, 4) in links
    assert len(capsules_of(among(robot, floor=None)).grounded) == 0


def test_what_an_arm_stands_on_is_not_in_its_way():
    stand = box((0.4, 0.4, 1.0), (0.0, 0.0, -0.5))
    capsules = capsules_of(among(pa10(), stand, floor=None))
    assert -1 not in capsules.link[capsules.blocked[:, 0]]
    assert capsules.clearance(np.zeros((1, 7))).min() > 0.03
    assert "'table'" in capsules.name(len(capsules.pairs))


LOW = """<robot name="low"><link name="base"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="shoulder"/>
<origin xyz="0 0 0.08" rpy="0 0 3.141593"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="150" velocity="3"/></joint><link name="shoulder"/>
<joint name="lift" type="revolute"><parent link="shoulder"/><child link="arm"/>
<origin xyz="0 0.13 0"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="150" velocity="3"/></joint>
<link name="arm"><inertial><mass value="8"/><origin xyz="0 0 0.21"/>
<inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.02"/></inertial></link></robot>"""


def test_a_shoulder_may_be_as_near_to_the_floor_as_it_was_built():
    """8 cm above it with an arm 6 cm thick: no pose at all was free."""
    robot = robot_from_urdf(LOW)
    bodies = capsules_of(robot)
    assert bodies.radius.max() > 0.05
    heights = [0.02, 0.1, 0.3]  # of the middle of the arm's far end
    lift = np.arccos((np.array(heights) - 0.08) / 0.42)
    gaps = bodies.clearance(np.column_stack([[0.3, -1.0, 2.0], lift]))
    low = gaps[:, len(bodies.pairs) :]
    assert [bodies.name(len(bodies.pairs) + k) for k in range(low.shape[1])] == [
        "link 2 and the floor"
    ]
    np.testing.assert_allclose(low[:, 0], np.array(heights) - bodies.radius.max(), atol=1e-9)


def test_a_box_around_the_whole_arm_is_in_its_way():
    trap = box((3.0, 3.0, 3.0), (0.0, 0.0, 0.5))
    capsules = capsules_of(among(pa10(), trap, floor=None))
    q = np.random.default_rng(0).uniform(-2, 2, (20, 7))
    inside = capsules.clearance(q)[:, len(capsules.pairs) :]
    assert inside.max(axis=1, initial=-np.inf).max() < 0
    assert set(capsules.link[capsules.blocked[:, 0]]) == {4, 6}


def test_a_column_around_the_shoulder_is_a_stand():
    """What turns in the column's own place stays out of it; what it carries does not."""
    column = box((0.5, 0.5, 2.0), (0.0, 0.0, -0.6))
    capsules = capsules_of(among(pa10(), column, floor=None))
    assert capsules.clearance(np.zeros((1, 7)))[:, len(capsules.pairs) :].min() > 0.03
    assert len(capsules.blocked) > 0


def test_gradient_of_the_hinge():
    capsules = capsules_of(pa10())
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (60, 7))
    q[:, 1] = 1.4  # low over the floor
    value, gradient = capsules.hinge(q, 0.3)
    assert value > 0
    way = np.random.default_rng(2).normal(size=q.shape)
    ahead, behind = (capsules.hinge(q + s * way, 0.3)[0] for s in (1e-6, -1e-6))
    assert np.sum(gradient * way) == pytest.approx((ahead - behind) / 2e-6, rel=1e-4)


@pytest.mark.parametrize("name", ["ur10", "panda", "kuka_lwr4", "kr300"])
def test_other_arms_have_room_to_move(name, shared_data):
    robot = robot_from_urdf(shared_data / name / "robot.urdf")
    capsules = capsules_of(robot)
    lower, upper = np.maximum(robot.lower, -3), np.minimum(robot.upper, 3)
    q = np.random.default_rng(0).uniform(lower, upper, (1500, robot.n))
    touching = (capsules.clearance(q) < 0).mean(axis=0)
    assert touching.max() < 0.4, capsules.name(int(np.argmax(touching)))
