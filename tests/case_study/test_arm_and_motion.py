"""What the case study runs: an arm of four joints with a secret, and a motion to judge by."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest

from backends.virtual.load_plant import load_plant
from pa10d.case_study.arm import hidden_friction, with_secret, write_profile
from pa10d.case_study.other import other_motion
from pa10d.services.robots import load_robot
from pa10d.trajectory.check import check
from pa10d.trajectory.excitation.optimise import excitation_problem
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.poses import Surroundings

ALL = (1, 2, 3, 4)


@pytest.fixture(scope="module")
def profile(tmp_path_factory):
    return write_profile(tmp_path_factory.mktemp("profiles"))


def test_the_daemon_s_profile_knows_nothing_of_the_secret(profile):
    assert load_robot(profile.path)[1].n == 4
    assert len(profile.drives) == 4
    assert profile.simulation.options == {}
    hidden = hidden_friction(3, profile, ALL)
    secret = with_secret(profile, 3, hidden)
    assert secret.simulation.options["effects"] == [asdict(one) for one in hidden]
    rise = load_plant(secret, 4).physics.friction.rise
    assert rise == pytest.approx([one.Fs for one in hidden])


def test_the_secret_follows_from_the_seed_alone(profile):
    assert hidden_friction(1, profile, ALL) == hidden_friction(1, profile, ALL)
    assert hidden_friction(1, profile, ALL) != hidden_friction(2, profile, ALL)
    (one,) = hidden_friction(1, profile, (2,))
    assert one == hidden_friction(1, profile, ALL)[1]


@pytest.mark.parametrize("seed", range(4))
def test_the_other_motion_is_fast_and_allowed(profile, seed):
    robot = load_robot(profile.path)[1]
    found = other_motion(excitation_problem(robot), 1, seed)
    plan = found.build(Surroundings.of(robot))
    assert check(plan, robot, limits_of(robot)) == []
    (span,) = plan.spans
    _, dq, _ = plan.at(np.arange(span.begin, span.end, 0.01))
    assert np.all((np.abs(dq) > 0.2).mean(axis=0) > 0.9)
