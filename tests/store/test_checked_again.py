"""A stored run is checked with what its import knew: units that were given, what the file told."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.services.robots import load_robot
from pa10d.services.runs import check_run, import_run
from pa10d.store import RunStore

URDF = """<robot name="r"><link name="a"/>
<joint name="turn" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit effort="50" velocity="9"/></joint>
<link name="b"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
ANGLES = {"degrees", "motor_side", "angle_unit"}


@pytest.fixture
def place(tmp_path):
    (tmp_path / "robot.urdf").write_text(URDF)
    t = np.arange(3000) / 100.0
    q = 0.8 * t + np.sin(t)  # 24 rad: a joint that turns on and on
    table = np.column_stack([t, q, np.random.default_rng(0).normal(0, 1, len(t))])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header="t,pos,torque_cmd", comments="")
    return tmp_path


def checked(place, unit, name):
    profile, robot = load_robot(place / "robot.urdf")
    store = RunStore(place / "data")
    mapping = ["t=time", f"pos{unit}=q1", "torque_cmd=tau1"]
    first = import_run(store, place / "a.csv", profile, robot, name=name, mapping=mapping)
    again = check_run(store, name, robot, profile)
    return {f.code for f in first.findings}, {f.code for f in again}


def test_a_unit_that_was_given_is_not_doubted_again(place):
    first, again = checked(place, "", "bare")
    assert first & ANGLES
    assert again & ANGLES
    first, again = checked(place, "[rad]", "given")
    assert not first & ANGLES
    assert not again & ANGLES


def test_what_only_the_file_told_is_not_forgotten(place):
    first, again = checked(place, "", "told")
    assert "commanded" in first
    assert "commanded" in again
