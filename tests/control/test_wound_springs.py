"""What is given ahead of a servo goes by where the links are, not by where rigid ones would be."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.control.joint_figures import presumed_figures
from pa10d.dynamics import robot_from_profile
from pa10d.dynamics.mass import mass_matrices
from pa10d.experiments.shaking import FLUNG, lines_of, multisine, small_torques, torque_ahead
from pa10d.experiments.shaking import SWING as SHAKES
from pa10d.experiments.wound_springs import LOSS, links_of
from pa10d.profile import load_profile
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.motions import MotionSamples
from pa10d.trajectory.poses import Surroundings

RATE, JOINT, SWING = 200.0, 0, 1.0  # Hz; the first axis is upright: gravity has no share
DAMPED = 0.3  # of critical damping, so that what begins ends
BENT = np.array([0.0, 1.2, 0.0, 0.6, 0.0, 0.0, 0.0])  # rad: much behind the first joint


@pytest.fixture(scope="module")
def robot():
    return robot_from_profile(load_profile("pa10-sim"))


def sprung(robot, joint=JOINT):
    """Figures of a joint behind a spring on which its link swings at ``SWING``."""
    link = mass_matrices(robot, BENT[None])[0, joint, joint]
    stiffness = np.full(robot.n, np.inf)
    stiffness[joint] = link * (2.0 * np.pi * SWING) ** 2
    known = presumed_figures(robot)
    return known.but(stiffness=stiffness, motor=known.rotor)


def swept(robot, hertz: float) -> MotionSamples:
    """Joint 1 to and fro by 0.2 rad, begun gently, for 8 s."""
    t = np.arange(round(8.0 * RATE)) / RATE
    w, grows = 2.0 * np.pi * hertz, np.clip(t / 4.0, 0.0, 1.0) ** 2
    way = np.zeros((3, len(t), robot.n))
    way[0] += BENT
    way[0, :, JOINT] = 0.2 * grows * np.sin(w * t)
    way[1] = np.gradient(way[0], 1.0 / RATE, axis=0)
    way[2] = np.gradient(way[1], 1.0 / RATE, axis=0)
    return MotionSamples(t, *way)


@pytest.mark.parametrize("hertz", [0.1, 0.5, 1.0, 5.0])
def test_a_link_follows_below_its_swing_and_stays_where_it_is_above(robot, hertz):
    motion, figures = swept(robot, hertz), sprung(robot)
    links = links_of(robot, figures, robot.parameters, motion, DAMPED)
    ratio = 1j * hertz / SWING
    share = abs((1.0 + 2.0 * DAMPED * ratio) / (1.0 + 2.0 * DAMPED * ratio + ratio**2))
    late = slice(round(5.0 * RATE), None)
    for values, own in zip(links[1:], motion[1:], strict=True):
        reached = np.abs(values[late, JOINT]).max() / np.abs(own[late, JOINT]).max()
        assert reached == pytest.approx(share, rel=0.15)
        assert np.array_equal(values[:, 1:], own[:, 1:])


def test_rigid_joints_are_where_their_motors_are(robot):
    motion = swept(robot, 0.5)
    assert links_of(robot, presumed_figures(robot), robot.parameters, motion, LOSS) is motion


def test_above_the_swing_the_motor_winds_its_spring_and_no_link(robot):
    motion, figures = swept(robot, 5.0), sprung(robot)
    asked = torque_ahead(robot, figures, motion, loss=DAMPED)[:, JOINT]
    rigid = torque_ahead(robot, presumed_figures(robot), motion)[:, JOINT]
    links = links_of(robot, figures, robot.parameters, motion, DAMPED)
    turned, own = motion.q - links.q, figures.rotor[JOINT] * motion.ddq[:, JOINT]
    loss = 2.0 * DAMPED * figures.stiffness[JOINT] / (2.0 * np.pi * SWING)
    wound = figures.stiffness[JOINT] * turned + loss * (motion.dq - links.dq)
    late = slice(round(5.0 * RATE), None)
    off = np.abs(asked - own - wound[:, JOINT])[late].max()
    assert off < 0.05 * np.abs(wound[late, JOINT]).max()
    assert np.abs(rigid - own)[late].max() > 5.0 * np.abs(asked - own)[late].max()


def test_small_torques_shake_no_more_than_moves(robot):
    """Sized for a rigid arm they would throw the rotor about."""
    around, heavy = Surroundings.of(robot), 1
    ask = {"kind": "first_motion", "parameters": {"part": "response", "joints": [heavy + 1]}}
    plan = read_request(ask).build(around)
    t = np.arange(1.0, round(plan.spans[0].end * RATE)) / RATE
    stiff, soft = (
        np.abs(small_torques(plan, robot, known, t, RATE)[:, heavy]).max()
        for known in (presumed_figures(robot), sprung(robot, heavy))
    )
    assert 0.0 < soft < 0.7 * stiff


@pytest.mark.parametrize("viscous", [0.0, 0.03, 0.3])
def test_what_rubs_is_shaken_as_far_as_what_does_not(viscous):
    """A wrist of 0.001 kg·m² that rubs with 0.3 N·m·s/rad: torques for its inertia alone moved it
    by a tenth of that, so that a neighbour's sway was taken for a spring in it."""
    rate, inertia = 5000.0, 0.001
    t, lines = np.arange(0.0, 3.0, 1.0 / rate), lines_of(333.0)
    torque = multisine(t, lines, np.full(len(lines), inertia), viscous)
    speed = np.zeros_like(t)
    for k in range(1, len(t)):
        speed[k] = (speed[k - 1] + torque[k] / rate / inertia) / (1.0 + viscous / rate / inertia)
    settled = speed[len(t) // 2 :]
    assert np.abs(settled - settled.mean()).max() == pytest.approx(1.0, rel=0.15)


@pytest.mark.parametrize("light", [1.0, 0.003], ids=["as it is", "a light wrist"])
def test_a_light_neighbour_is_not_flung_about(robot, light):
    """One of 5e-4 kg·m² had 2.4 rad/s within 20 ms, as a joint far below it was shaken."""
    around = Surroundings.of(robot)
    plan = read_request({"kind": "first_motion", "parameters": {"part": "response"}}).build(around)
    figures, t = presumed_figures(robot), np.arange(0.0, plan.duration, 1.0 / RATE)
    heavy, wrist = 1, 5
    figures = figures.but(rotor=np.where(np.arange(robot.n) == wrist, 1e-6, figures.rotor))
    factor = np.where(np.arange(robot.n) == wrist, light, 1.0)
    torque = np.abs(small_torques(plan, robot, figures.but(link=factor), t, RATE)).max(axis=0)
    usual = np.abs(small_torques(plan, robot, figures, t, RATE)).max(axis=0)
    assert torque[0] == usual[0] > 0.0
    span = next(span for span in plan.spans if span.label == f"joint {heavy + 1} shaken")
    q, dq, _ = plan.at(np.array([0.5 * (span.begin + span.end)]))
    mass = mass_matrices(robot, q)[0]
    given = mass[wrist, heavy] / (light * mass[wrist, wrist]) * SHAKES * abs(dq[0, heavy])
    most = FLUNG * robot.velocity[wrist]
    share = torque[heavy] / usual[heavy]
    assert share == pytest.approx(min(1.0, most / abs(given)), rel=0.1)
    assert (share < 0.7) == (light < 1.0), "nothing was shown"
