"""Two joints, one above the other, that lean together."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.control.gains import PidGains, _coupled, first_gains
from pa10d.control.joint_figures import presumed_figures
from pa10d.control.limits import arm_limits
from pa10d.control.swaying import Coupled, settled
from pa10d.control.torque_path import SOFT
from pa10d.dynamics import robot_from_profile
from pa10d.profile import load_profile

KI = np.array([232.5, 31.9])


def upright(coupled=1.0, stiff=(113.4, 20.3)):
    """Two rods on end at 100 Hz, as two joints of an arm that fell; coupled: of what each feels of
    the other."""
    mass, slope = np.array([[2.1, 0.7], [0.7, 0.31]]), np.array([[37.0, 11.5], [11.5, 11.5]])
    apart = np.eye(2) + coupled * (1.0 - np.eye(2))
    late = np.full(2, 0.0125)
    return Coupled(
        (mass * apart)[None], (slope * apart)[None], np.array(stiff), np.array([18.5, 2.2]), late
    )


def swing(arm, ki, seconds=20.0, step=1e-3):
    """rad that a lean of 0.01 has become, of a joint that answers ``late``, in small steps."""
    delay = round(arm.late[0] / step)
    q, v, total = np.array([0.01, 0.01]), np.zeros(2), np.zeros(2)
    past = [np.zeros(2)] * delay
    largest = []
    for _ in range(round(seconds / step)):
        total += q * step
        past.append(-arm.stiff * q - arm.damps * v - ki * total)
        v = v + step * np.linalg.solve(arm.mass[0], past.pop(0) + arm.slope[0] @ q)
        q = q + step * v
        largest.append(np.abs(q).max())
    return max(largest[-round(3.0 / step) :])


def test_what_is_calm_joint_by_joint_sways_up_together():
    np.testing.assert_array_equal(settled(upright(coupled=0.0), KI), KI)
    assert swing(upright(coupled=0.0), KI) < 1e-3
    assert swing(upright(), KI) > 0.02
    chosen = settled(upright(), KI)
    assert (chosen <= KI).all()
    assert chosen[1] > 0.1 * KI[1], "no more than it takes"
    assert swing(upright(), chosen) < 1e-3


def test_where_gravity_is_stronger_than_stiffness_less_integral_action_does_not_help():
    np.testing.assert_array_equal(settled(upright(stiff=(113.4, 11.0)), KI), KI)


@pytest.mark.parametrize("ki", [np.zeros(2), np.array([0.0, 31.9])])
def test_joints_without_integral_action_keep_none(ki):
    assert (settled(upright(), ki) <= ki).all()


@pytest.mark.parametrize("name", ["panda", "xarm6"])
def test_a_servo_that_is_softened_still_outweighs_gravity(name):
    """As it swung an arm got a quarter of its stiffness, and leant over in a third of its poses."""
    profile = load_profile(name)
    robot = robot_from_profile(profile)
    figures = presumed_figures(robot)
    bound = arm_limits(profile, robot).following_error
    gains = first_gains(robot, profile.control, bound).softened(SOFT)
    arm = _coupled(robot, profile.control, figures, gains)
    assert len(arm.standing().mass) == len(arm.mass), "19 to 24 of 64 poses were not held"
    assert np.linalg.eigvals(arm.system(gains.ki)).real.max() < 1e-6, "nor does it sway up"
    old = PidGains.from_document({k: getattr(gains, k).tolist() for k in ("kp", "ki", "kd")})
    assert (old.softened(SOFT).kp == SOFT**2 * old.kp).all(), "kept by an older version"
