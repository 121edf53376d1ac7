"""The arms that are shipped besides the PA10: they load, they move, they can be identified."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

import pa10d
from backends.ports import Port
from backends.virtual.datasets import make_runs
from backends.virtual.load_plant import start_pose
from backends.virtual.machine import VirtualArm
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.profile import load_profile
from pa10d.services.robots import load_robot, shipped_robots
from pa10d.trajectory.poses import Surroundings

ARMS = {"cobra600": 4, "iiwa14": 7, "panda": 7, "puma560": 6, "ur5e": 6, "xarm6": 6}
EACH = pytest.mark.parametrize("name", ARMS)


class _Nowhere(Port):
    def send(self, packet):
        pass

    def receive(self, timeout):
        return b""

    def close(self):
        pass


@EACH
def test_it_loads_and_every_limit_is_known(name):
    profile, robot = load_robot(name)
    assert robot.n == ARMS[name]
    for limit in (robot.lower, robot.upper, robot.velocity, robot.effort, robot.acceleration):
        assert np.isfinite(limit).all()
    text = profile.path.read_text() + profile.urdf.read_text()
    assert "ublished" in text
    assert "assumed" in text or "estimates" in text or name == "panda"


@EACH
def test_the_virtual_arm_wakes_up_where_nothing_is_met(name):
    profile, robot = load_robot(name)
    around = Surroundings.of(robot)
    start = start_pose(profile, robot.n)
    assert around.allowed(start[None])[0]
    assert around.limits.rest_pose() == pytest.approx(start)
    arm = VirtualArm(profile, _Nowhere())
    assert arm.mechanics.q == pytest.approx(start, abs=1e-5)


QUICK = ("cobra600", "ur5e")


@pytest.mark.by_default("cobra600")
@pytest.mark.parametrize(
    "name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.long) for n in ARMS]
)
def test_it_moves_in_simulated_time_and_is_identified(name):
    """On a motion that the fit has not seen what is left is a few times the sensors' noise."""
    robot = pa10d.load_robot(name)
    runs, _ = make_runs(3, [], "white", ("train_a", "valid_a"), load_profile(name), seconds=12.0)
    train, valid = (pa10d.Run(run.t, run.q, run.tau) for run in runs.values())
    assert np.ptp(valid.q, axis=0).min() > 0.05
    model = pa10d.identify(robot, [train])
    left = pa10d.compare(model, [valid]).rms
    size = np.sqrt(np.mean(valid.tau**2, axis=0))
    assert (left < 0.15 * size).all()


def test_they_are_listed_with_what_they_are():
    found = {one["name"]: one for one in shipped_robots()}
    assert set(ARMS) | {"pa10-sim", "pa10-7c"} <= set(found)
    assert all(one["says"] and one["joints"] > 0 for one in found.values())


def test_a_home_beyond_the_limits_is_refused(tmp_path):
    document = yaml.safe_load(load_profile("panda").path.read_text())
    document |= {"urdf": str(load_profile("panda").urdf), "home": [0.0] * 7}
    path = tmp_path / "p.yaml"
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(Exception, match=r"home\.4: found 0, expected .* -3\.0718 to -0\.0698"):
        load_robot(path)


def test_the_puma_weighs_as_its_authors_measured():
    """Gravity of joint 2: the explicit model of Armstrong, Khatib and Burdick has g1 = -37.2 N·m of
    the upper arm and g2 = -8.44 N·m of what the elbow carries."""
    robot = robot_from_profile(load_profile("puma560"))
    still, out = np.zeros((1, 6)), np.array([[0, 0, -np.pi / 2, 0, 0, 0]])
    torque = inverse_dynamics(robot, robot.parameters, out, still, still)
    assert torque[0, 1] == pytest.approx(37.2 + 8.44, rel=0.02)
