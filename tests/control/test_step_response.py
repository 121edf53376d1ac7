"""A small step: its motion, and the figures of a response that a closed form knows."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.control.limits import arm_limits
from pa10d.control.motion_check import wrong_with_rows
from pa10d.experiments.step_response import steps_of
from pa10d.services.library import open_library
from pa10d.services.responses import responses
from pa10d.services.robots import load_robot
from pa10d.store.channels import Channels, CommandedMotion, Samples
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.kinds.step import SmallStep
from pa10d.trajectory.poses import Surroundings

RATE = 500.0


@pytest.fixture(scope="module")
def arm():
    return load_robot("pa10-sim")


def swing(t, damping, omega):
    """Of a second-order system to a unit step at 0: its closed form."""
    damped = omega * np.sqrt(1 - damping**2)
    phase = damping / np.sqrt(1 - damping**2)
    ringing = np.cos(damped * t) + phase * np.sin(damped * t)
    return np.where(t < 0, 0.0, 1 - np.exp(-damping * omega * np.maximum(t, 0)) * ringing)


@pytest.mark.parametrize("damping", [0.2, 0.5, 0.7])
@pytest.mark.parametrize("size", [0.05, -0.03])
def test_figures_are_those_of_the_closed_form(damping, size):
    omega, t = 12.0, np.arange(0, 4, 1 / RATE)
    target = np.where(t > 1 - 1e-9, size, 0.0)
    begin = t[np.flatnonzero(np.diff(target))[0]]
    (one,) = steps_of(t, target, size * swing(t - begin, damping, omega))
    assert one.size == pytest.approx(size)
    overshoot = np.exp(-np.pi * damping / np.sqrt(1 - damping**2))
    assert one.overshoot == pytest.approx(overshoot, abs=2e-3)
    fine = np.linspace(0, 3, 300_001)
    unit = swing(fine, damping, omega)
    rise = fine[np.argmax(unit >= 0.9)] - fine[np.argmax(unit >= 0.1)]
    assert one.rise == pytest.approx(rise, abs=2 / RATE)
    settled = fine[np.flatnonzero(np.abs(unit - 1) > 0.05)[-1]]
    assert one.settling == pytest.approx(settled, abs=2 / RATE)


def test_a_joint_that_never_gets_there_says_so():
    t = np.arange(0, 2, 1 / RATE)
    target = np.where(t > 0.5, 0.05, 0.0)
    (one,) = steps_of(t, target, 0.8 * target)
    assert (one.rise, one.settling, one.overshoot) == (None, None, 0.0)
    assert "does not get there" in one.sentence(3)
    assert steps_of(t, np.zeros_like(t), t) == []


def test_it_is_as_sharp_as_control_takes(arm):
    profile, robot = arm
    around, limits = Surroundings.of(robot), arm_limits(profile, robot)
    plan = SmallStep(joints=[2, 7]).build(around)
    samples = plan.sample(RATE)
    rows = np.hstack([samples.q, samples.dq, samples.ddq, np.zeros_like(samples.q)])
    assert wrong_with_rows(rows, 0, len(rows), samples.q[0], limits, 1 / RATE) is None
    for span in plan.spans:
        j = span.joint - 1
        inside = (samples.t >= span.begin) & (samples.t <= span.end)
        assert np.ptp(samples.q[inside, j]) == pytest.approx(0.05)
        sharpest = np.abs(samples.ddq[inside, j]).max() / limits.acceleration[j]
        assert 0.95 < sharpest <= 1.0


def test_a_joint_at_its_end_steps_the_other_way_or_not_at_all(arm):
    around = Surroundings.of(arm[1])
    pose = around.limits.rest_pose()
    pose[0] = around.limits.upper[0] - 0.01
    plan = SmallStep(joints=[1], pose=pose.tolist()).build(around)
    assert plan.sample(RATE).q[:, 0].min() == pytest.approx(pose[0] - 0.05)
    with pytest.raises(UserError, match="expected a number of at most"):
        read_request({"kind": "step", "parameters": {"size": 0.3}})


def test_runs_stand_beside_each_other(arm, tmp_path):
    profile, robot = arm
    plan = SmallStep(joints=[4]).build(Surroundings.of(robot))
    motion, library = plan.sample(RATE), open_library(tmp_path)
    gains = {key: [1.0] * 7 for key in ("kp", "ki", "kd")}
    for name, late, law in (("before", 10, "pid"), ("after", 2, "computed_torque")):
        control = {"law": law, "model": None, "ahead": False, "gains": gains}
        told = json.dumps({**plan.to_dict(), "control": control})
        channels = Channels(joints=robot.joint_names, commands=True)
        writer = library.runs.start(name, channels, profile, plan=told, kind="step")
        q = np.vstack([np.repeat(motion.q[:1], late, axis=0), motion.q[:-late]])
        sent = CommandedMotion(motion.q, motion.dq, np.zeros_like(q))
        stamps = (motion.t * 1e9).round().astype(np.int64)
        writer.append(Samples(stamps, q, np.zeros_like(q), commands=sent))
        writer.close()
    before, after = responses(str(tmp_path), ["before", "after"], 4).items
    assert [one.control.law for one in (before, after)] == ["pid", "computed_torque"]
    assert before.steps[0].rise == pytest.approx(before.steps[0].target_rise, abs=1e-6)
    late = before.steps[0].settling - after.steps[0].settling
    assert late == pytest.approx(8 / RATE)
    assert before.moved == [4]
    assert before.rms > 4 * after.rms
    assert abs(before.time[0] + 0.1) < 2 / RATE
    still = responses(str(tmp_path), ["before"], 1).items[0]
    assert (still.steps, still.rms) == ([], 0.0)
    with pytest.raises(UserError, match="found 8, expected 1 to 7"):
        responses(str(tmp_path), ["before"], 8)
