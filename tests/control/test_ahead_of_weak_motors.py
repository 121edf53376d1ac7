"""A joint whose weight takes most of its torque limit, and turns over on the way, is given all of
what it needs beside what holds it where it begins: more than that limit."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pa10d.control.joint_figures import presumed_figures
from pa10d.control.limits import arm_limits
from pa10d.control.motion_check import wrong_with_rows
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.experiments.motion import measured_torque, rows_of, whole_motion
from pa10d.experiments.pacing import Joints, paced
from pa10d.profile import load_profile
from pa10d.services.joints import learnt
from pa10d.trajectory.plan import Plan, Segment, move
from pa10d.trajectory.poses import Surroundings

RATE, SHARE, LEANS = 125.0, 0.7, 1.2  # Hz; of the torque limit, that its weight takes; rad
URDF = """<robot name="nod"><link name="b"/>
<joint name="q1" type="revolute"><parent link="b"/><child link="l1"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<link name="l1"><inertial><origin xyz="0 0 0.4"/><mass value="5"/>
<inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
WEIGHS = 5.0 * 0.4 * 9.80665  # N·m at most
PROFILE = f"""name: nod
urdf: nod.urdf
joints: [q1]
limits: {{velocity: [1.0], acceleration: [2.0], torque: [{WEIGHS / SHARE:.3f}]}}
control: {{rate: {RATE}}}
environment: {{floor: none}}
"""


@pytest.fixture(scope="module")
def nod():
    """Profile, robot, limits, and a plan from one side to the other."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "nod.urdf").write_text(URDF)
        Path(folder, "nod.yaml").write_text(PROFILE)
        profile = load_profile(str(Path(folder, "nod.yaml")))
        robot = robot_from_profile(profile)
    around = Surroundings.of(robot)
    way = Segment(move(np.array([-LEANS]), np.array([LEANS]), around.limits))
    plan = Plan("point_to_point", (1,), (way,))
    return profile, robot, arm_limits(profile, robot), plan


def test_it_is_given_all_of_it_and_that_is_taken(nod):
    _, robot, limits, plan = nod
    figures = presumed_figures(robot)
    whole = whole_motion(plan, plan.start, robot, RATE)
    ahead = measured_torque(plan, whole, robot, figures, RATE)
    t, q, dq, ddq = whole.samples
    asked = inverse_dynamics(robot, robot.parameters, q, dq, ddq) + figures.rotor * ddq
    assert ahead == pytest.approx(asked - asked[0], abs=1e-9)
    assert np.abs(ahead).max() > 1.2 * limits.torque[0]
    rows = rows_of(whole, None, None)
    rows[:, -1:] += ahead
    assert wrong_with_rows(rows, whole.first, whole.last, q[0], limits, t[1] - t[0]) is None


def test_so_it_is_followed_at_full_speed(nod):
    profile, robot, limits, plan = nod
    known = learnt(profile, robot, presumed_figures(robot))
    chosen = paced(
        plan, plan.start, robot, limits, RATE, Joints(known.figures, known.gains, ahead=True)
    )
    assert chosen.adjusted is not None, chosen.check.sentence
    assert chosen.adjusted.pace == 1.0
    assert chosen.plan is plan


def test_no_more_than_its_limit_and_no_step_where_a_urdf_says_too_much(nod):
    _, robot, limits, plan = nod
    whole = whole_motion(plan, plan.start, robot, RATE)
    heavy = presumed_figures(robot)
    heavy = replace(heavy, bodies=2.0 * heavy.bodies)
    ahead = measured_torque(plan, whole, robot, heavy, RATE)
    assert np.abs(ahead[0]).max() == 0.0
    most = limits.torque[0]
    assert np.ptp(ahead) == pytest.approx(2.0 * most, rel=1e-9)
