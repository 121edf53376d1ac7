"""A mount that is not the profile's is told by what the joints weigh, and no rough URDF is."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.control.joint_figures import ROUGH, presumed_figures
from pa10d.control.known_joints import KnownJoints
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.experiments.felt_bodies import felt_bodies
from pa10d.experiments.mounting import leaning_mount, wrong_mount
from pa10d.experiments.seen import Seen
from pa10d.profile import load_profile
from pa10d.services import joints
from pa10d.trajectory.plan import Plan

RATE, SECONDS = 50.0, 8.0
LEANING = np.array([0.0, 0.5, 0.2, 1.0, 0.1, 0.6, 0.0])


@pytest.fixture(scope="module")
def robot():
    return robot_from_profile(load_profile("pa10-sim"))


def moved(robot, off, down, seed=0):
    """Strokes about a pose, as the arm would be with bodies ``off`` times as heavy as its URDF's,
    their centres elsewhere, and gravity along ``down``; joints rub."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(SECONDS * RATE)) / RATE
    w = 2.0 * np.pi / SECONDS * rng.integers(1, 4, robot.n)
    q = LEANING + 0.35 * np.sin(np.outer(t, w))
    dq, ddq = 0.35 * w * np.cos(np.outer(t, w)), -0.35 * w**2 * np.sin(np.outer(t, w))
    bodies = robot.parameters * off[:, None]
    bodies[:, 1:4] *= rng.uniform(0.7, 1.3, (robot.n, 1))
    true = robot.with_gravity(9.81 * down)
    torque = inverse_dynamics(true, bodies, q, dq, ddq) + rubs(robot) * np.sign(dq)
    return [(q, torque, RATE)]


def rubs(robot):
    return 0.02 * robot.effort


def said(robot, off, down, seed=0):
    figures = presumed_figures(robot)
    known = figures.but(coulomb=rubs(robot), rotor=0.0 * figures.rotor)
    return wrong_mount(robot, known, moved(robot, off, down, seed))


@pytest.mark.parametrize(
    ("down", "words"),
    [((0, 0, 1), "the other way"), ((1, 0, 0), r"along \+x of the base"), ((0, -1, 0), "along -y")],
)
def test_gravity_points_elsewhere(robot, down, words):
    off = np.exp(np.random.default_rng(1).uniform(-0.7, 0.7, robot.n))
    assert re.search(words, said(robot, off, np.array(down, float)))


@pytest.mark.parametrize("seed", range(4))
def test_a_rough_urdf_is_no_wrong_mount(robot, seed):
    rng = np.random.default_rng(seed)
    off = np.exp(rng.uniform(-np.log(ROUGH), np.log(ROUGH), robot.n))
    assert said(robot, off, np.array([0.0, 0.0, -1.0]), seed) is None


def test_nor_is_what_feels_no_gravity(robot):
    down = np.array([0.0, 0.0, -1.0])
    weightless = replace(robot, gravity=np.zeros(3))
    assert said(weightless, np.ones(robot.n), 0.0 * down) is None


def test_a_first_motion_ends_with_that(robot, monkeypatch):
    """No gains would help, and every weight that was felt would be another one."""
    profile, turned = load_profile("pa10-sim"), np.array([0.0, 0.0, 1.0])
    figures = presumed_figures(robot).but(coulomb=rubs(robot), rotor=np.zeros(robot.n))
    ((q, torque, rate),) = moved(robot, np.ones(robot.n), turned)
    seen = Seen(Plan("first_motion", (1,), ()), rate, q, torque)
    for name, value in (
        ("load_robot", (profile, robot)), ("open_library", None), ("_seen", seen),
        ("measured_figures", figures),
    ):  # fmt: skip
        monkeypatch.setattr(joints, name, lambda *_, value=value: value)
    known = joints.learnt(profile, robot, presumed_figures(robot)).document()
    with pytest.raises(UserError, match=r"gravity points the other way.*base\.rpy"):
        joints.learn("", "", {"response": "r"}, known)


LEANS = np.array([0.13, -0.11, -0.985])  # by ten degrees


def felt(robot, off, down, seed=0):
    """N·m RMS by which the weights of felt bodies are wrong over the arm's range, beside gravity as
    the profile has it, and what is said."""
    figures = presumed_figures(robot)
    known = figures.but(coulomb=rubs(robot), rotor=0.0 * figures.rotor)
    seen = moved(robot, off, down, seed)
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (200, robot.n))
    bodies = robot.parameters * off[:, None]
    bodies[:, 1:4] *= np.random.default_rng(seed + 1000).uniform(0.9, 1.1, (robot.n, 1))
    weights = [inverse_dynamics(robot, each, q, 0.0 * q, 0.0 * q)
               for each in (felt_bodies(robot, known, seen)[0], bodies)]  # fmt: skip
    return np.sqrt(((weights[0] - weights[1]) ** 2).mean(axis=0)), leaning_mount(robot, known, seen)


@pytest.mark.parametrize("seed", range(3))
def test_a_base_that_leans_is_said_and_bodies_are_not_bent_for_it(robot, seed, monkeypatch):
    off = np.exp(np.random.default_rng(seed).uniform(-0.4, 0.4, robot.n))
    down = LEANS / np.linalg.norm(LEANS)
    wrong, said = felt(robot, off, down, seed)
    told = [float(v) for v in re.findall(r"-?\d+\.\d+", said.partition("[")[2])[:3]]
    assert np.linalg.norm(np.array(told) / 9.81 - down) < 0.06
    monkeypatch.setattr("pa10d.experiments.felt_bodies._leaning", lambda *_: None)
    bent, nothing = felt(robot, off, down, seed)
    assert nothing is None
    assert (wrong[1:4] < 0.75 * bent[1:4]).all()


@pytest.mark.parametrize("seed", range(4))
def test_a_base_that_stands_as_it_should_is_not_said_to_lean(robot, seed):
    off = np.exp(np.random.default_rng(seed).uniform(-1.0, 1.0, robot.n))
    _, said = felt(robot, off, np.array([0.0, 0.0, -1.0]), seed)
    assert said is None


def seen_leaning(robot, seed=0):
    """A motion of an arm whose base leans by ten degrees, its bodies as the URDF has them."""
    down = LEANS / np.linalg.norm(LEANS)
    ((q, torque, rate),) = moved(robot, np.ones(robot.n), down, seed)
    return Seen(Plan("tracking", (), ()), rate, q, torque)


@pytest.fixture
def known(robot):
    figures = presumed_figures(robot)
    figures = figures.but(coulomb=rubs(robot), rotor=0.5 * figures.rotor)
    return joints.begun(load_profile("pa10-sim"), robot, figures)[0]


def test_a_later_motion_tells_of_a_lean_as_well(robot, known):
    again = joints.felt_more(load_profile("pa10-sim"), robot, known, {}, [seen_leaning(robot)])
    assert "the base leans by about" in again.lean
    assert again.sentences[-1] == again.lean


def test_a_lean_that_was_told_is_not_forgotten(robot, known, monkeypatch):
    """Neither by one more motion, which hides it among other errors, nor by calmer gains, nor in
    the file that is kept."""
    profile = load_profile("pa10-sim")
    told = known.leaning("the base leans")
    monkeypatch.setattr(joints, "leaning_mount", lambda *_: None)
    later = joints.felt_more(profile, robot, told, {}, [seen_leaning(robot)])
    calmer = joints.calmed(profile, robot, told, 3, 20.0).known
    for one in (later, calmer, KnownJoints.from_document(told.document())):
        assert one.lean == "the base leans"
        assert one.sentences.count("the base leans") == 1
    straight = known.document()
    del straight["lean"]
    assert KnownJoints.from_document(straight).lean == "", "an older file"
