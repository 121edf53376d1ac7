"""Signs, gears, counters: each wrong recording is named with the line that mends it; put right it
is silent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from one_ur5e import recorded, ur5e

from pa10d.checks import check_recording
from pa10d.checks.geometry import check_geometry
from pa10d.dynamics import inverse_dynamics, robot_from_urdf
from pa10d.measurement.counters import lost_sign, upper_half
from pa10d.measurement.recording import Recording
from pa10d.readers import read_recording
from pa10d.services.robots import load_robot

CODES = {"turned", "torque_scale", "wrapped"}


@pytest.fixture(scope="module")
def robot():
    return ur5e()


@pytest.fixture(scope="module")
def clean():
    return recorded(15.0)


def _said(run, robot):
    return [(f.code, f.joint, f.advice) for f in check_geometry(run, robot)]


def _turned(run, joint, q=1, tau=1):
    angles, torques = run.q.copy(), run.tau.copy()
    angles[:, joint - 1] *= q
    torques[:, joint - 1] *= tau
    return replace(run, q=angles, tau=torques)


def test_a_clean_recording_is_silent(clean, robot):
    assert _said(clean, robot) == []


@pytest.mark.by_default("2--1-1")
@pytest.mark.parametrize(
    ("joint", "q", "tau", "line"),
    [
        (2, -1, 1, "--map 'q2[-1]=q2'"),
        (3, 1, -1, "--map 'tau3[-1]=tau3'"),
        (3, -1, -1, "--map 'q3[-1]=q3' 'tau3[-1]=tau3'"),
    ],
)
def test_a_joint_turned_round_is_named_with_its_line(clean, robot, joint, q, tau, line):
    assert _said(_turned(clean, joint, q, tau), robot) == [("turned", joint, line)]


@pytest.mark.by_default("joints1")
@pytest.mark.parametrize("joints", [(3, 4), (1, 2, 3, 4, 5, 6)])
def test_torques_turned_round_together_are_named_by_friction_that_would_drive(clean, robot, joints):
    """What joints do to each other is then as good with the others turned round instead."""
    run = clean
    for joint in joints:
        run = _turned(run, joint, tau=-1)
    found = list(check_geometry(run, robot))
    assert [(f.code, f.joint, f.advice) for f in found] == [
        ("turned", j, f"--map 'tau{j}[-1]=tau{j}'") for j in joints
    ]
    assert all("friction would drive the joint" in f.sentence for f in found)


STANDING = """<robot name="two"><link name="base"/>
<joint name="a" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/></joint>
<link name="l1"><inertial><mass value="3"/><origin xyz="0.04 0 0.2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="b" type="continuous"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/>
<origin xyz="0 0 0.4"/></joint>
<link name="l2"><inertial><mass value="2"/><origin xyz="0.02 0 0.15"/>
<inertia ixx="0.03" iyy="0.03" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


@pytest.mark.parametrize(
    ("joint", "q", "tau"), [(None, 1, 1), (1, 1, -1), (2, 1, -1), (1, -1, -1), (2, -1, -1)]
)
def test_a_spring_that_outweighs_gravity_turns_no_joint_round(joint, q, tau):
    """Gravity pulls both links down with the sum of their angles; a spring in the elbow that is
    twice as strong looks like gravity with the difference."""
    robot = robot_from_urdf(STANDING)
    rng = np.random.default_rng(1)
    t = np.arange(4000) / 200.0
    w, a, p = 2 * np.pi * rng.uniform(0.08, 0.9, (6, 2)), *rng.uniform(0.1, 0.3, (2, 6, 2))
    angle = w * t[:, None, None] + 20 * p
    angles, speeds = (a * np.sin(angle)).sum(1), (a * w * np.cos(angle)).sum(1)
    pushes = -(a * w**2 * np.sin(angle)).sum(1)
    torques = inverse_dynamics(robot, robot.parameters, angles, speeds, pushes) + 2 * speeds
    torques += rng.normal(0, 0.05, torques.shape) + angles * [0, 6]
    run = Recording("sprung", t, angles, torques, None)
    found = _said(run if joint is None else _turned(run, joint, q, tau), robot)
    assert [(code, which) for code, which, _ in found] == [("turned", joint)] * (joint is not None)


def test_torques_of_the_motor_side_are_named_with_their_factor(clean, robot):
    found = _said(replace(clean, tau=clean.tau / 100.0), robot)
    assert {(code, joint) for code, joint, _ in found} >= {("torque_scale", 2)}
    advice = next(advice for _, joint, advice in found if joint == 2)
    factor = float(advice.split("[")[1].split("]")[0])
    assert 70 < factor < 140
    assert "gear ratio" in advice


def test_a_counter_without_its_sign_is_named_and_mended(tmp_path, robot, clean):
    raw = np.round(clean.tau * 100.0)
    lost = Recording("lost", clean.t, clean.q, np.mod(raw, 65536.0), None)
    found = [f for f in check_recording(lost, None, robot, delay=False) if f.code == "wrapped"]
    assert {f.joint for f in found} == {1, 2, 3, 4, 5, 6}
    assert all(f.severity == "error" for f in found)
    assert "'tau1[i16]=tau1'" in found[0].advice
    names = ["time", *(f"q{j}" for j in range(1, 7)), *(f"raw{j}" for j in range(1, 7))]
    table = np.column_stack([lost.t, lost.q, lost.tau])
    file = tmp_path / "lost.csv"
    np.savetxt(file, table, fmt="%.10g", delimiter=",", header=",".join(names), comments="")
    profile, arm = load_robot("ur5e")
    back = read_recording(file, profile, arm, ["raw{n}[i16*0.01]=tau"])
    np.testing.assert_allclose(back.samples.tau, raw / 100.0, atol=1e-12)
    assert back.wraps == {}
    scaled = read_recording(file, profile, arm, ["raw{n}[0.01]=tau"])
    assert set(scaled.wraps) == {f"tau{j}" for j in range(1, 7)}, "a factor hides no lost sign"


def test_a_torque_that_leaps_over_zero_has_lost_its_sign_as_well():
    signs = np.sign(np.sin(np.arange(2000) / 40.0 + 0.1))
    raw = np.round(7000 * signs + 300 * np.cos(np.arange(2000) / 7.0))
    assert lost_sign(np.mod(raw, 65536.0)) == 16
    assert lost_sign(raw + 30000) is None


def test_a_torque_that_never_crosses_zero_has_lost_its_sign_as_well(clean):
    below = np.round(-2000 + 900 * np.sin(clean.t))
    tau = clean.tau.copy()
    tau[:, 1] = np.mod(below, 65536.0)
    run = replace(clean, tau=tau)
    (found,) = [f for f in check_recording(run, None, None, delay=False) if f.code == "wrapped"]
    assert found.joint == 2
    assert "tau stays between 32768 and 65536" in found.sentence
    assert upper_half(below + 4000) is None
    assert upper_half(np.mod(below, 65536.0) + 0.5) is None


def test_signals_that_are_no_counters_do_not_wrap():
    t = np.linspace(0, 10, 1000)
    assert lost_sign(np.abs(50 * np.sin(t))) is None
    assert lost_sign(np.round(100 + 90 * np.sin(t))) is None
    assert lost_sign(np.where(t > 5, 300.0, 0.0)) is None


REAL = ["bam_xl330", "double_pendulum", "kr300", "kuka_lwr4", "laas_motor", "panda", "ur10"]


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [*REAL, "samples/s01", "samples/s02", "samples/s03", "samples/s04"]
)
def test_recordings_of_others_raise_no_false_alarm(shared_data, name):
    folder = shared_data / name
    here = folder / "robot.urdf"
    profile, robot = load_robot(here if here.is_file() else folder.parent / "robot.urdf")
    for file in sorted([*folder.glob("*.csv"), *folder.glob("*.csv.gz")]):
        found = read_recording(file, profile, robot)
        s = found.samples
        run = Recording(file.name, found.timing.grid, s.q, s.tau, s.dq)
        said = check_recording(run, found.timing, robot)
        assert [str(f) for f in said if f.code in CODES | {"commanded"}] == []
