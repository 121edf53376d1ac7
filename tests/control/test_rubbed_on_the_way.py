"""A joint that fell behind in its strokes has told its viscous friction until then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pa10d.control.faults import Fault
from pa10d.control.joint_figures import first_figures
from pa10d.dynamics import robot_from_profile
from pa10d.experiments.seen import Seen
from pa10d.profile import load_profile
from pa10d.services.joints import begun, rubbed, told_on_the_way
from pa10d.trajectory.plan import Plan

RATE, AT, DRY = 100.0, 5, 1.2  # Hz, 0-based, N·m
FELL = Fault("following_error", "is 0.15 rad from where it should be", axis=AT, was_there=True)


@pytest.fixture(scope="module")
def arm():
    """Its dry friction is known from small slow motions."""
    profile = load_profile("pa10-sim")
    control = profile.control.model_copy(update={"rate": RATE})
    profile = profile.model_copy(update={"control": control})
    robot = robot_from_profile(profile)
    dry = np.where(np.arange(robot.n) == AT, DRY, 0.0)
    figures = first_figures(robot, np.zeros((2, robot.n))).but(coulomb=dry)
    return profile, robot, begun(profile, robot, figures)[0]


def strokes(robot, viscous, bears=0.0, stands=False):
    """To and fro at 0.35 rad/s, and faster until it fell behind; all others stand."""
    t = np.arange(round(6.0 * RATE)) / RATE
    speed = 0.35 * np.sign(np.sin(2.0 * np.pi * t / 3.0)) * (1.0 + (t > 4.5))
    speed = np.convolve(speed, np.ones(20) / 20.0, mode="same") * (t > 0.5)
    speed *= not stands
    q, torque = np.zeros((len(t), robot.n)), np.zeros((len(t), robot.n))
    q[:, AT] = np.cumsum(speed) / RATE
    torque[:, AT] = DRY * np.sign(speed) + viscous * speed + bears * (1.0 - q[:, AT])
    torque[:, AT] += 0.02 * np.gradient(speed, 1.0 / RATE)
    if stands:
        torque[:, AT] = DRY * np.sin(2.0 * np.pi * t / 3.0)
    return Seen(Plan("first_motion", (), ()), RATE, q, torque)


def test_it_is_given_what_its_strokes_told(arm):
    profile, robot, known = arm
    seen = strokes(robot, viscous=1.5, bears=2.0)
    found = told_on_the_way(profile, robot, known, FELL, seen, "response")
    assert found.known.figures.viscous[AT] == pytest.approx(0.7 * 1.5, rel=0.25)
    assert found.known.figures.coulomb[AT] == DRY
    assert "joint 6 fell behind: " in found.note
    assert "of viscous friction, which slower motions had not shown" in found.note
    others = np.arange(robot.n) != AT
    assert (found.known.figures.viscous[others] == 0.0).all()


def test_not_where_friction_does_not_explain_it_nor_where_it_may_have_met_something(arm):
    profile, robot, known = arm
    assert rubbed(profile, robot, known, FELL, strokes(robot, 0.0)) is None
    assert rubbed(profile, robot, known, FELL, strokes(robot, 0.0, stands=True)) is None
    pressed = replace(known, gains=replace(known.gains, kp=1e3 * known.gains.kp))
    met = replace(FELL, was_there=False)
    assert rubbed(profile, robot, pressed, met, strokes(robot, 1.5)) is None
