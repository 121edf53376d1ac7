"""The PA10's two profiles say what the published facts and the fixed points say."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.profile import load_profile

BOTH = pytest.mark.parametrize("name", ["pa10-7c", "pa10-sim"])


@pytest.fixture(scope="module")
def facts(shared):
    return yaml.safe_load((shared / "pa10" / "pa10_facts.yaml").read_text())


@BOTH
def test_limits_are_those_of_the_fixed_points(name):
    limits = load_profile(name).limits
    assert limits.velocity == pytest.approx([1, 1, 2, 2, *[2 * np.pi] * 3])
    assert limits.acceleration == [3, 3, 6, 6, 18, 18, 18]


@BOTH
def test_limits_and_drives_agree_with_the_facts(name, facts):
    profile = load_profile(name)
    robot = robot_from_profile(profile)
    assert robot.joint_names == tuple(facts["joints"]["names"])
    assert robot.upper == pytest.approx(facts["limits"]["position"], abs=1e-4)
    assert robot.lower == pytest.approx(-robot.upper)
    assert robot.effort == pytest.approx(facts["limits"]["peak_joint_torque"])
    drives, drive = profile.drives, facts["drive"]
    assert [d.node for d in drives] == [1, 2, 3, 4, 5, 6, 7]
    assert [d.gear_ratio for d in drives] == drive["gear_ratio"]
    assert {d.counts_per_rev for d in drives} == {drive["position_counts_per_joint_rev"]}
    millinewtonmetres = facts["cia402"]["pa10_6076_mNm"]
    assert [d.rated_torque for d in drives] == pytest.approx([m / 1000 for m in millinewtonmetres])
    peak = [d.rated_torque * d.gear_ratio for d in drives]
    assert peak == pytest.approx(profile.limits.torque)


def test_only_the_bus_tells_the_simulated_arm_from_the_real_one():
    real, simulated = load_profile("pa10-7c"), load_profile("pa10-sim")
    assert (real.can.interface, real.can.channel) == ("socketcan", "can0")
    assert simulated.can.interface == "virtualbus"
    assert real.simulation is None
    assert simulated.simulation is not None
    same = {"path", "name", "can", "simulation", "safety"}  # a simulator may be kept waiting
    assert real.model_dump(exclude=same) == simulated.model_dump(exclude=same)


def test_the_urdf_weighs_and_pulls_like_the_facts(facts):
    """Gravity torque at random poses from Denavit-Hartenberg frames and the published centres of
    mass, against the URDF: two descriptions of one arm."""
    robot = robot_from_profile(load_profile("pa10-sim"))
    rng = np.random.default_rng(4)
    poses = rng.uniform(robot.lower, robot.upper, (20, 7))
    still = np.zeros_like(poses)
    ours = inverse_dynamics(robot, robot.parameters, poses, still, still)
    theirs = np.array([_gravity_torque(facts, pose) for pose in poses])
    np.testing.assert_allclose(ours, theirs, atol=1e-6)


def _gravity_torque(facts, pose, step=1e-6):
    """Slope of the potential energy, by differences."""
    out = np.zeros(7)
    for j in range(7):
        ends = []
        for sign in (1, -1):
            moved = pose.copy()
            moved[j] += sign * step
            ends.append(_energy(facts, moved))
        out[j] = (ends[0] - ends[1]) / (2 * step)
    return out


def _energy(facts, pose):
    table = facts["kinematics"]["modified_dh"]
    along = facts["inertial"]["com_along_arm_z_in_urdf_link_frame"]
    frame, energy = np.eye(4), 0.0
    origins = [0.0, 0.317, 0.317, 0.767, 0.767, 1.247, 1.247]  # of the URDF's links at zero
    for j in range(7):
        frame = frame @ _modified_dh(table["alpha_deg"][j], table["d"][j], pose[j])
        up = origins[j] + along[j]  # the mass centre's height on the straight arm
        local = np.linalg.inv(_straight(table, j)) @ [0, 0, up, 1]
        energy += facts["inertial"]["mass"][j] * 9.81 * (frame @ local)[2]
    return energy


def _straight(table, j):
    frame = np.eye(4)
    for k in range(j + 1):
        frame = frame @ _modified_dh(table["alpha_deg"][k], table["d"][k], 0.0)
    return frame


def _modified_dh(alpha_deg, d, theta):
    ca, sa = np.cos(np.radians(alpha_deg)), np.sin(np.radians(alpha_deg))
    ct, st = np.cos(theta), np.sin(theta)
    turn = np.array([[1, 0, 0, 0], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1]])
    return turn @ np.array([[ct, -st, 0, 0], [st, ct, 0, 0], [0, 0, 1, d], [0, 0, 0, 1]])
