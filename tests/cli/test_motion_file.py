"""``pa10d experiment --to``: a motion for an arm that another program moves."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pa10d.cli import main
from pa10d.services.command_documents import MotionFile

SMALL = """<robot name="one"><link name="base"/><link name="rod"><inertial><mass value="1"/>
<origin xyz="0 0 0.2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
</inertial></link><joint name="swing" type="revolute"><parent link="base"/><child link="rod"/>
<origin xyz="0 0 0.8"/><axis xyz="0 1 0"/><limit lower="-1" upper="1.5" effort="20"
velocity="2"/></joint></robot>"""


@pytest.fixture
def asked(tmp_path, monkeypatch, capsys):
    """asked(*words) -> (status, what was printed, what was said beside it): nobody to move the arm
    is there, and no daemon is started."""
    (tmp_path / "robot.urdf").write_text(SMALL)
    monkeypatch.chdir(tmp_path)

    def ask(*words: str):
        status = main(["--data", str(tmp_path / "data"), "experiment", *words,
                       "--profile", "robot.urdf"])  # fmt: skip
        said = capsys.readouterr()
        return status, said.out, said.err

    return ask


def test_the_motion_is_a_table_within_the_limits(asked, tmp_path):
    status, out, _ = asked("load_sweep", "--to", "motion.csv", "--json")
    assert status == 0
    told = json.loads(out)
    assert told.keys() == MotionFile.model_validate(told).model_dump().keys()
    t, q = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1, unpack=True)
    assert (tmp_path / "motion.csv").read_text().splitlines()[0] == "time,q1"
    assert t[-1] == pytest.approx(told["seconds"], abs=0.011)
    assert -1.0 < q.min() < q.max() < 1.5
    speed = np.diff(q) / np.diff(t)
    assert np.abs(speed).max() < 2.0
    assert abs(speed[0]) < 0.02 > abs(speed[-1])


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (("load_sweep", "--to", "nowhere/motion.csv"), "--to nowhere/motion.csv: no such folder"),
        (("load_sweep", "--set", "joints=[9]", "--to", "m.csv"), "joints: found 9, expected"),
        (("sweeping", "--to", "m.csv"), "kind: found 'sweeping', expected one of"),
    ],
)
def test_what_is_wrong_is_one_line_and_leaves_no_file(asked, tmp_path, words, line):
    status, out, said = asked(*words)
    assert (status, out) == (1, "")
    assert said.startswith(line)
    assert said.count("\n") == 1
    assert not list(tmp_path.glob("*m*.csv"))
