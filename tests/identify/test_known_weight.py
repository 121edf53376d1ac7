"""The guided motion and the analysis together, on virtual arms with wrong torque constants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.stats import binom

from backends.virtual.datasets.runs import run_motion
from backends.virtual.plant import build
from pa10d.common.errors import UserError
from pa10d.dynamics import inverse_dynamics
from pa10d.dynamics.carried import carrying
from pa10d.dynamics.robot import robot_from_profile
from pa10d.identify.scale import Body, Load, predicted_errors, torque_gains
from pa10d.profile import load_profile
from pa10d.trajectory.capsules import capsules_of
from pa10d.trajectory.check import check
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.plan import Plan
from pa10d.trajectory.poses import Surroundings

CENTRE = (0.05, 0.0, 0.1)
PLACE = (0.002, 0.002, 0.002)


@dataclass
class Course:
    plan: Plan

    def sample(self, t):
        return self.plan.at(np.clip(t, 0.0, self.plan.duration))


def planned(robot, mass, **more) -> Plan:
    parameters = {"mass": mass, "com": list(CENTRE), **more}
    request = read_request({"kind": "known_weight", "parameters": parameters})
    return request.build(Surroundings.of(robot))


def weighed(name: str, seed: int, **more):
    """An arm whose masses, friction and torque constants nobody was told, and a weight that is as
    far from what is stated as it may be → true gains, what was found, what was foretold."""
    profile = load_profile(name)
    robot = robot_from_profile(profile)
    rng = np.random.default_rng(seed)
    true = rng.uniform(0.85, 1.15, robot.n)
    mass = round(float(rng.uniform(2.0, 5.0)), 2)
    body = Body(mass, CENTRE, 0.002 * mass, PLACE)
    plan = planned(robot, mass, seed=seed, **more)
    x, y, z = np.array(body.com) + rng.normal(size=3) * PLACE
    really = mass + rng.normal() * body.mass_error
    weight = {"effect": "payload", "mass": really, "cx": x, "cy": y, "cz": z}
    recordings = []
    for day, effects in enumerate(([], [weight])):
        plant = build(
            profile, effects=effects, seed=100 * seed + day,
            dynamics={"spread": 0.2, "seed": seed}, torque_gains=true.tolist(),
        )  # fmt: skip
        recordings.append(run_motion(plant, profile, Course(plan), plan.duration, 200.0)[0])
    empty, loaded = recordings
    before = predicted_errors(robot, torque_gains(robot, [empty], []), body)
    return true, torque_gains(robot, [empty], [Load([loaded], body)]), before


@pytest.mark.long
def test_gains_come_back_within_their_errors_and_as_foretold():
    true, found, before = weighed("ur5e", 1, count=4, speed=0.6)
    off = (found.gain - true) / found.std_error
    assert np.isfinite(off[1:]).all()
    assert np.nanmax(np.abs(off)) < 3.5
    assert np.abs(true - 1).max() > 0.1
    assert (found.std_error[1:3] < 0.01).all()
    ratio = (found.std_error / found.gain / before)[1:]
    assert ((ratio > 1 / 3) & (ratio < 3)).all()


@pytest.mark.long
@pytest.mark.parametrize("name", ["ur5e", "pa10-sim", "panda"])
def test_stated_errors_cover(name):
    """20 arms: as many gains within 1.96 stated errors as chance lets a true error have."""
    off = []
    for seed in range(20):
        true, found, _ = weighed(name, seed)
        off += list(((found.gain - true) / found.std_error)[np.isfinite(found.gain)])
    inside = int((np.abs(off) < 1.96).sum())
    assert len(off) > 20 * 4
    assert binom.cdf(inside, len(off), 0.95) > 0.01, (inside, len(off))


def test_the_motion_loads_every_joint_it_can_and_says_which_it_cannot():
    robot = robot_from_profile(load_profile("pa10-sim"))
    plan = planned(robot, 3.0)
    assert [note for note in plan.notes if "joint 1:" in note]
    assert len(plan.notes) == 1
    seen = plan.sample(20.0)
    only = Body(3.0, CENTRE, 0.0, PLACE).parameters(robot)
    asked = inverse_dynamics(robot, only, seen.q, 0 * seen.q, 0 * seen.q)
    most = np.abs(asked).max(axis=0)
    rms = np.sqrt((asked**2).mean(axis=0))
    assert (rms[1:] > 0.3 * most[1:]).all()
    assert (most[1:6] > 1.0).all()


def test_every_pose_is_passed_in_both_directions_at_the_same_speed():
    robot = robot_from_profile(load_profile("ur5e"))
    plan = planned(robot, 2.0)
    t = np.linspace(0.0, plan.duration, 400)
    q, dq, _ = plan.at(t)
    back, undone, _ = plan.at(plan.duration - t)
    np.testing.assert_allclose(q, back, atol=1e-9)
    np.testing.assert_allclose(dq, -undone, atol=1e-6)


def test_the_weight_is_part_of_what_must_not_meet_anything():
    robot = robot_from_profile(load_profile("ur5e"))
    far = carrying(robot, 4.0, np.array([0.0, 0.0, 0.4]))
    bare, loaded = capsules_of(robot), capsules_of(far)
    was, now = (b.radius[np.any(b.start != b.end, axis=1)] for b in (bare, loaded))
    np.testing.assert_array_equal(now[:-1], was)
    assert now[-1] == pytest.approx(0.0495, abs=1e-3)  # a ball of 4 kg of iron
    plan = planned(robot, 4.0)
    assert check(plan, carrying(robot, 4.0, np.array(CENTRE)), limits_of(robot)) == []


def test_a_weight_that_is_too_heavy_is_one_line():
    robot = robot_from_profile(load_profile("ur5e"))
    with pytest.raises(UserError, match=r"80 kg; expected at least 6: a lighter weight"):
        planned(robot, 80.0)


@pytest.mark.parametrize("gains", [[1.0], "x", [1.0] * 6 + [0], [1.0] * 6 + [True]])
def test_wrong_torque_gains_of_the_virtual_arm_are_one_line(gains):
    with pytest.raises(UserError, match=r"torque_gains: found .*, expected 7 numbers above 0"):
        build(load_profile("pa10-sim"), torque_gains=gains)
