"""``pa10d profile new``: one profile from one URDF, taken by every command at once."""

from __future__ import annotations

import json

import numpy as np
import pytest

from backends.virtual.load_plant import load_plant
from pa10d.cli import main
from pa10d.cli.profiles import _dialogue
from pa10d.control.limits import arm_limits
from pa10d.services.new_profile import answers_for, facts_of
from pa10d.services.robots import load_robot
from pa10d.trajectory.poses import Surroundings

LINK = '<link name="{0}"><inertial><origin xyz="0 0 -0.2"/><mass value="{1}"/><inertia ixx="{2}" ixy="0" ixz="0" iyy="{2}" iyz="0" izz="0.01"/></inertial></link>'  # noqa: E501
JOINT = '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><origin xyz="0 0 {5}"/><axis xyz="0 1 0"/>{4}</joint>'  # noqa: E501
FULL = '<limit lower="-2" upper="2" effort="40" velocity="1.5"/>'
BARE = '<limit lower="-2" upper="2" effort="0" velocity="0"/>'


def robot(*joints, mass=3.0, inertia=0.05):
    """A chain of (name, type, limit)."""
    parts = ['<robot name="arm"><link name="base"/>']
    parent = "base"
    for k, (name, kind, limit) in enumerate(joints):
        parts.append(JOINT.format(name, kind, parent, f"l{k}", limit, 1.5 if k == 0 else -0.4))
        parts.append(LINK.format(f"l{k}", mass, inertia))
        parent = f"l{k}"
    return "".join([*parts, "</robot>"])


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(text):
        (tmp_path / "robot.urdf").write_text(text)
        return tmp_path

    return write


def test_it_is_taken_at_once_and_says_what_is_assumed(folder, capsys):
    place = folder(robot(("a", "revolute", FULL), ("b", "revolute", BARE)))
    assert main(["--json", "profile", "new", "robot.urdf"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "pa10d/profile-new/1"
    assert found["file"] == str(place / "arm.yaml")
    assert found["joints"] == ["a", "b"]
    assert found["assumed"] == {"velocity": [2], "acceleration": [1, 2], "torque": [2]}
    profile, arm = load_robot(place / "arm.yaml")
    limits = arm_limits(profile, arm)
    assert limits.velocity.tolist() == [1.5, 1.0]
    held = facts_of(place / "robot.urdf").weight[1]
    assert limits.torque[1] > held > 0
    assert load_plant(profile, 2).n == 2
    text = (place / "arm.yaml").read_text()
    assert "assumed for joint 2" in text
    assert "# N·m (N) at the joint" in text


def test_no_file_is_overwritten_unasked(folder, capsys):
    place = folder(robot(("a", "revolute", FULL)))
    (place / "arm.yaml").write_text("mine")
    assert main(["profile", "new", "robot.urdf", "--yes"]) == 1
    assert "arm.yaml: exists already; expected --out" in capsys.readouterr().err
    assert (place / "arm.yaml").read_text() == "mine"
    assert main(["profile", "new", "robot.urdf", "--yes", "--replace"]) == 0
    assert load_robot(place / "arm.yaml")[1].n == 1
    assert sorted(p.name for p in place.iterdir()) == ["arm.yaml", "robot.urdf"]


@pytest.mark.parametrize("rate", [50, 125, 500])
def test_a_simulated_arm_of_any_rate_is_one_at_once(folder, rate):
    """100 cycles without news are more than a profile may allow below 200 Hz."""
    place = folder(robot(("a", "revolute", FULL)))
    assert main(["profile", "new", "robot.urdf", "--yes", "--rate", str(rate)]) == 0
    profile, _ = load_robot(place / "arm.yaml")
    assert profile.safety.stale_cycles == 0.2 * rate


def test_options_are_the_answers(folder):
    place = folder(robot(("a", "revolute", FULL), ("b", "continuous", "")))
    words = ["--name", "two", "--mounting", "ceiling", "--velocity", "1,2", "--torque", "50"]
    words += ["--tool-mass", "1.5", "--tool-com", "0,0,0.1", "--bus", "can1", "--rate", "100"]
    assert main(["profile", "new", "robot.urdf", *words, "--acceleration", "4"]) == 0
    profile, arm = load_robot(place / "two.yaml")
    assert arm.velocity.tolist() == [1, 2]
    assert arm.effort.tolist() == [50, 50]
    assert arm.acceleration.tolist() == [4, 4]
    assert arm.gravity == pytest.approx([0, 0, 9.81], abs=1e-6)
    assert profile.tool.mass == 1.5
    assert (profile.can.interface, profile.can.channel) == ("socketcan", "can1")
    assert profile.control.rate == 100
    assert profile.simulation is None
    assert np.isfinite([arm.lower, arm.upper]).all()  # a joint that turns for ever gets ±π


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--velocity", "fast"], "--velocity fast: expected a number above 0"),
        (["--velocity", "1,2,3"], "--velocity 1,2,3: expected a number above 0"),
        (["--torque", "-5"], "--torque -5: expected a number above 0"),
        (["--mounting", "tree"], "--mounting tree: expected floor, ceiling, wall or three angles"),
        (["--tool-mass", "-1"], "--tool-mass -1: expected a number of at least 0"),
        (["--rate", "9000"], "--rate 9000: expected a number of Hz that 1 drives"),
        (["--name", "a/b"], "--name a/b: expected a name without slashes"),
        (["--joints", "z"], "joint 'z' is not a movable joint; expected some of a"),
        (["--out", "no/such/a.yaml"], "no folder no/such; expected an existing one"),
    ],
)
def test_a_wrong_answer_is_one_line(folder, capsys, words, said):
    place = folder(robot(("a", "revolute", FULL)))
    assert main(["profile", "new", "robot.urdf", *words]) == 1
    error = capsys.readouterr().err.strip().splitlines()
    assert said in error[-1]
    assert [p.name for p in place.iterdir()] == ["robot.urdf"]


def test_a_urdf_without_inertias_is_said(folder, capsys):
    text = (
        robot(("a", "revolute", FULL)).replace("<inertial>", "<!--").replace("</inertial>", "-->")
    )
    place = folder(text)
    assert main(["profile", "new", "robot.urdf"]) == 0
    assert "warning: the URDF has no inertias" in capsys.readouterr().err
    assert "# Doubt: the URDF has no inertias" in (place / "arm.yaml").read_text()


def test_bodies_that_cannot_exist_are_doubted(folder):
    place = folder(robot(("a", "revolute", FULL), inertia=0.004))
    assert any("no body has the principal moments" in d for d in _doubts(place))
    place = folder(robot(("a", "revolute", FULL), inertia=1).replace('izz="0.01"', 'izz="1"'))
    assert any("placeholder" in d for d in _doubts(place))


def test_links_that_are_all_alike_are_doubted(folder):
    chain = robot(*((name, "revolute", FULL) for name in "abcd"))
    assert any("4 links in a row have the same mass, 3 kg" in d for d in _doubts(folder(chain)))
    for k in range(4):
        chain = chain.replace('izz="0.01"', f'izz="0.010{k}"', 1)
    assert not any("the same mass" in d for d in _doubts(folder(chain)))


def test_torque_that_nobody_has_stated_is_doubted(folder):
    chain = robot(("a", "revolute", FULL.replace("40", "5000")), ("b", "revolute", FULL))
    assert not any("placeholder" in d for d in _doubts(folder(chain)))
    assert any("5000 N·m" in d for d in _doubts(folder(chain.replace('"40"', '"5000"'))))
    level = chain.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0 1"/>')  # bears no weight at all
    level = level.replace('xyz="0 0 -0.2"', 'xyz="0.3 0 0"')
    assert not any("placeholder" in d for d in _doubts(folder(level)))


def _doubts(place):
    return facts_of(place / "robot.urdf").doubts


def test_an_arm_that_lies_on_the_floor_at_zero_gets_a_home(folder):
    chain = robot(*((name, "revolute", FULL) for name in "abc"))
    place = folder(chain.replace('xyz="0 0 1.5"', 'xyz="0 0 0.5"'))
    facts = facts_of(place / "robot.urdf")
    assert facts.home is not None
    assert main(["profile", "new", "robot.urdf"]) == 0
    profile, arm = load_robot(place / "arm.yaml")
    assert profile.home == pytest.approx(arm.home)


def test_an_arm_that_hangs_below_its_base_gets_no_floor(folder, capsys):
    narrow = FULL.replace("2", "1")
    chain = robot(*((name, "revolute", narrow) for name in "ab"))
    place = folder(chain.replace('xyz="0 0 1.5"', 'xyz="0 0 0"'))
    assert main(["profile", "new", "robot.urdf"]) == 0
    assert "no floor is assumed" in capsys.readouterr().err
    arm = load_robot(place / "arm.yaml")[1]
    assert arm.environment.floor is None
    around = Surroundings.of(arm)
    assert around.allowed(around.limits.rest_pose()[None])[0]


def test_the_dialogue_asks_again_and_takes_defaults(folder, capsys):
    place = folder(robot(("a", "revolute", FULL)))
    said = iter(["mine", "", "quick", "3", "", "", "", "", ""])
    shown = []

    def read(prompt):
        shown.append(prompt)
        return next(said)

    answers = answers_for(facts_of(place / "robot.urdf"), "arm", {}, _dialogue(read))
    assert answers.name == "mine"
    assert answers.velocity == [3.0]
    assert answers.acceleration == [9.0]
    assert answers.torque == [40.0]
    assert "'quick': expected a number above 0" in capsys.readouterr().err
    assert any("[1.5]" in prompt for prompt in shown)


FINGER = '<limit lower="0" upper="0.04" effort="20" velocity="0.2"/>'


def test_a_gripper_s_fingers_are_left_out_and_said(folder, capsys):
    place = folder(
        robot(("a", "revolute", FULL), ("b", "revolute", FULL), ("finger", "prismatic", FINGER))
    )
    assert main(["profile", "new", "robot.urdf"]) == 0
    assert "warning: finger left out: its range leaves no room" in capsys.readouterr().err
    assert load_robot(place / "arm.yaml")[1].joint_names == ("a", "b")


def _with_jaws(text, first="l1", second="l1"):
    """A driven jaw behind the last link, and one that follows it."""
    jaws = JOINT.format("jaw", "revolute", first, "l7", FULL, 0.1) + LINK.format("l7", 0.1, 0.1)
    far = JOINT.format("far", "revolute", second, "l8", FULL + '<mimic joint="jaw"/>', 0.1)
    return text.replace("</robot>", f"{jaws}{far}{LINK.format('l8', 0.1, 0.1)}</robot>")


def test_a_gripper_of_two_jaws_is_left_out_and_said(folder, capsys):
    folder(_with_jaws(robot(("a", "revolute", FULL), ("b", "revolute", FULL))))
    assert main(["profile", "new", "robot.urdf"]) == 0
    said = capsys.readouterr().err
    assert "warning: jaw left out, which far follows (mimic): taken for a gripper" in said
    assert load_robot("arm.yaml")[1].joint_names == ("a", "b")


def test_a_part_that_follows_the_arm_is_missing_in_it_and_said(folder, capsys):
    folder(_with_jaws(robot(("a", "revolute", FULL), ("b", "revolute", FULL)), second="l7"))
    assert main(["profile", "new", "robot.urdf"]) == 0
    assert "warning: far follows jaw (mimic): held where it is zero" in capsys.readouterr().err
    assert load_robot("arm.yaml")[1].joint_names == ("a", "b", "jaw")


def test_limits_in_degrees_are_doubted(folder):
    degrees = '<limit lower="-170" upper="170" effort="40" velocity="90"/>'
    place = folder(robot(("a", "revolute", degrees), ("b", "continuous", "")))
    doubts = [doubt for doubt in _doubts(place) if "degrees" in doubt]
    assert len(doubts) == 1
    assert "joint 1 (a) may turn from -170 to 170 rad" in doubts[0]


def test_a_tree_is_asked_which_arm_it_is(folder, capsys):
    text = robot(("a", "revolute", FULL), ("b", "revolute", FULL))
    head = JOINT.format("head", "revolute", "l0", "l9", FULL, 0.3) + LINK.format("l9", 1, 0.01)
    folder(text.replace("</robot>", f"{head}</robot>"))
    assert main(["profile", "new", "robot.urdf"]) == 0
    assert "not one arm but a tree of 3 joints (a, b, head)" in capsys.readouterr().err
    assert main(["profile", "new", "robot.urdf", "--replace", "--joints", "a", "b"]) == 0
    assert "tree" not in capsys.readouterr().err


@pytest.mark.parametrize("space", ["", ' xmlns:xacro="http://www.ros.org/wiki/xacro"'])
def test_a_xacro_file_is_called_so(folder, capsys, space):
    folder(f'<robot name="x"{space}><xacro:include filename="a.xacro"/></robot>')
    assert main(["profile", "new", "robot.urdf"]) == 1
    assert "robot.urdf: a xacro file; expected the URDF that 'xacro" in capsys.readouterr().err
