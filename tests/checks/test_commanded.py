"""A torque that a controller asked for is told from one that was measured, by name and by law."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.services.robots import load_robot
from pa10d.services.runs import import_run
from pa10d.store import RunStore

URDF = """<robot name="two"><link name="base"/>
<joint name="a" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l1"><inertial><mass value="3"/><inertia ixx="0.1" iyy="0.1" izz="0.05" ixy="0" ixz="0"
iyz="0"/></inertial></link>
<joint name="b" type="revolute"><parent link="l1"/><child link="l2"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l2"><inertial><mass value="2"/><inertia ixx="0.03" iyy="0.03" izz="0.01" ixy="0"
ixz="0" iyz="0"/></inertial></link></robot>"""
RATE, STEPS = 500.0, 10  # Hz, steps of the integration per sample


@pytest.fixture(scope="module")
def servo():
    """Two joints under PD control: what the controller asks for passes a current loop of 5 ms and
    a motor with cogging before it moves anything, and a sensor that wavers by 1 % tells of it."""
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 12.0, 1.0 / RATE)
    wanted = 0.8 * np.sin(t[:, None] * [2.1, 3.3]) + 0.2 * np.sin(t[:, None] * [5.0, 7.1])
    pace = np.gradient(wanted, t, axis=0)
    q, dq, motor = np.zeros(2), np.zeros(2), np.zeros(2)
    rows = []
    for k in range(len(t)):
        asked = 60.0 * (wanted[k] - q) + 6.0 * (pace[k] - dq)
        rows.append(np.concatenate([q, dq, asked, motor]))
        h = 1.0 / (RATE * STEPS)
        for _ in range(STEPS):
            motor = motor + h / 0.005 * (asked - motor)
            real = motor + 0.2 * np.sin(12.0 * q)
            dq = dq + h / 0.2 * (real - 2.0 * np.sin(q) - 0.4 * np.tanh(dq / 0.01) - 0.5 * dq)
            q = q + h * dq
    q, dq, asked, motor = np.split(np.array(rows), 4, axis=1)
    felt = motor + 0.2 * np.sin(12.0 * q)
    felt = felt + 0.01 * felt.std(axis=0) * rng.normal(size=felt.shape)
    assert np.abs(asked - felt).max() > 0.05 * np.abs(asked).max()
    return t, q, dq, wanted, asked, felt


def findings(folder, servo, torque, names, with_wanted=True, with_dq=True):
    """What an import says of the torque's origin."""
    t, q, dq, wanted, *_ = servo
    (folder / "robot.urdf").write_text(URDF)
    profile, robot = load_robot(folder / "robot.urdf")
    blocks = {"position": q, names: torque}
    blocks |= {"velocity": dq} if with_dq else {}
    blocks |= {"desired_position": wanted} if with_wanted else {}
    head = ["time", *(f"{name}_{j}" for name in blocks for j in (1, 2))]
    table = np.column_stack([t, *blocks.values()])
    path = folder / "log.csv"
    np.savetxt(path, table, delimiter=",", header=",".join(head), comments="", fmt="%.9g")
    rules = ["position_{n}=q", f"{names}_{{n}}=tau"]
    rules += ["velocity_{n}=dq"] if with_dq else []
    result = import_run(RunStore(folder / "data"), path, profile, robot, mapping=rules)
    return [f for f in result.findings if f.code == "commanded"]


@pytest.mark.by_default("False")
@pytest.mark.parametrize("with_dq", [True, False])
def test_a_commanded_torque_is_a_law_on_the_tracking_error(servo, tmp_path, with_dq):
    found = findings(tmp_path, servo, servo[4], "torque", with_dq=with_dq)
    assert [f.joint for f in found] == [1, 2]
    assert found[0].sentence.startswith("joint 1 (a): tau is a PD law on the tracking error")
    assert found[0].severity == "warning"
    assert "map the measured torque" in found[0].advice


@pytest.mark.parametrize("with_dq", [True, False])
def test_a_measured_torque_is_none(servo, tmp_path, with_dq):
    assert findings(tmp_path, servo, servo[5], "torque", with_dq=with_dq) == []


def test_a_column_that_is_called_a_command_is_named(servo, tmp_path):
    (found,) = findings(tmp_path, servo, servo[4], "torque_cmd", with_wanted=False)
    assert found.sentence.startswith("torque_cmd_1, torque_cmd_2: a torque that was asked for")


def test_without_the_wanted_positions_a_law_cannot_be_told(servo, tmp_path):
    assert findings(tmp_path, servo, servo[4], "torque", with_wanted=False) == []


@pytest.mark.parametrize("friction", [0.0, 1.5])
def test_what_inertia_and_viscous_friction_need_is_no_command(tmp_path, friction):
    """A loop that lags evenly makes the tracking error a law of speed and acceleration."""
    t = np.arange(0.0, 12.0, 1.0 / RATE)
    late = (t - 0.008)[:, None]
    w = np.array([2.1, 3.3])
    q, dq, ddq = np.sin(late * w), w * np.cos(late * w), -(w**2) * np.sin(late * w)
    needed = 0.5 * ddq + friction * dq
    assert findings(tmp_path, (t, q, dq, np.sin(t[:, None] * w)), needed, "torque") == []
