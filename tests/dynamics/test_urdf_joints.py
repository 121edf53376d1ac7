"""URDFs as makers write them: joints from the tip, names that joints and links share."""

from __future__ import annotations

import re

import numpy as np
import pytest

from backends.limits import axis_limits
from backends.virtual.plant.arm import reduced_model
from pa10d.common.errors import UserError
from pa10d.dynamics import inverse_dynamics, robot_from_profile, robot_from_urdf
from pa10d.profile import load_profile

BODY = (
    '<inertial><mass value="{m}"/><origin xyz="0.1 0 0.2"/>'
    '<inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0" ixz="0" iyz="0"/></inertial>'
)
LIMIT = '<limit lower="-3" upper="3" effort="10" velocity="2"/>'


def joint(name, above, below, kind="revolute", axis="0 1 0", more=""):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{above}"/><child link="{below}"/>'
        f'<origin xyz="0 0 0.3"/><axis xyz="{axis}"/>{LIMIT}{more}</joint>'
    )


def link(name, mass):
    return f'<link name="{name}">{BODY.format(m=mass)}</link>'


def urdf(*parts):
    return f'<robot name="arm"><link name="base"/>{"".join(parts)}</robot>'


LINKS = (link("l1", 3), link("l2", 2), link("l3", 1))
CHAIN = (
    joint("pan", "base", "l1", axis="0 0 1"), joint("lift", "l1", "l2"), joint("roll", "l2", "l3"),
)  # fmt: skip


@pytest.mark.parametrize(("stated", "lower"), [("0.3", 0.3), ("0", -np.inf)])
def test_a_joint_that_has_no_way_is_not_one_without_limits(stated, lower):
    """Both limits at 0.3 rad were none; both at 0 are what a file without them says."""
    limit = LIMIT.replace('"-3"', f'"{stated}"').replace('"3"', f'"{stated}"')
    robot = robot_from_urdf(urdf(*LINKS, CHAIN[0].replace(LIMIT, limit), *CHAIN[1:]))
    assert robot.lower.tolist() == [lower, -3.0, -3.0]
    assert robot.upper.tolist() == [-lower if lower < 0 else lower, 3.0, 3.0]


def test_joints_count_from_the_base_though_the_file_begins_at_the_tip(tmp_path):
    from_tip = urdf(*reversed(CHAIN), *LINKS)
    robot = robot_from_urdf(from_tip)
    assert robot.joint_names == ("pan", "lift", "roll")
    (tmp_path / "arm.urdf").write_text(from_tip)
    assert list(reduced_model(tmp_path / "arm.urdf", None).names)[1:] == [*robot.joint_names]
    same = robot_from_urdf(urdf(*LINKS, *CHAIN))
    q, dq, ddq = np.random.default_rng(1).normal(size=(3, 5, 3))
    for arm in (robot, same):
        assert arm.joint_names == same.joint_names
    np.testing.assert_array_equal(
        inverse_dynamics(robot, robot.parameters, q, dq, ddq),
        inverse_dynamics(same, same.parameters, q, dq, ddq),
    )


def test_the_file_s_order_stands_where_it_can():
    arms = (joint("b", "base", "l1"), joint("a", "base", "l2"), joint("c", "l1", "l3"))
    assert robot_from_urdf(urdf(*arms, *LINKS)).joint_names == ("b", "a", "c")
    assert robot_from_urdf(urdf(*arms, *LINKS), ["c", "a", "b"]).joint_names == ("c", "a", "b")


@pytest.mark.parametrize("wanted", [None, ["pan"]])
def test_a_link_that_is_called_like_a_joint(tmp_path, wanted):
    """Others are held still only where the two are told apart."""
    named = urdf(
        joint("pan", "base", "l1"), joint("hand", "l1", "hand", "fixed"),
        joint("finger", "hand", "finger"), link("l1", 3), link("hand", 2), link("finger", 1),
    )  # fmt: skip
    other = named.replace('link="hand"', 'link="h"').replace('<link name="hand"', '<link name="h"')
    other = other.replace('link="finger"', 'link="f"')
    other = other.replace('<link name="finger"', '<link name="f"')
    one, two = robot_from_urdf(named, wanted), robot_from_urdf(other, wanted)
    np.testing.assert_array_equal(one.parameters, two.parameters)
    (tmp_path / "arm.urdf").write_text(named)
    model = reduced_model(tmp_path / "arm.urdf", wanted)
    assert list(model.names)[1:] == [*one.joint_names]
    assert sum(model.inertias[k].mass for k in range(1, model.njoints)) == pytest.approx(6)


def test_a_joint_that_follows_another_does_not_move_by_itself(tmp_path):
    follows = joint("finger", "l2", "l3", more='<mimic joint="lift"/>')
    text = urdf(*CHAIN[:2], follows, *LINKS)
    assert robot_from_urdf(text).joint_names == ("pan", "lift")
    (tmp_path / "arm.urdf").write_text(text)
    assert list(reduced_model(tmp_path / "arm.urdf", None).names)[1:] == ["pan", "lift"]


def test_what_carries_the_arm_and_follows_is_no_joint_to_hold_still():
    """A linkage that keeps the tool level: held at zero it would be an arm of another geometry."""
    level = joint("level", "l2", "l3", more='<mimic joint="lift" multiplier="-1"/>')
    tool = joint("roll", "l3", "l4")
    with pytest.raises(UserError, match=r"'level' follows 'lift' \(mimic\) and carries 'roll'"):
        robot_from_urdf(urdf(*CHAIN[:2], level, tool, *LINKS, link("l4", 1)))
    through = joint("level", "l2", "l3", more='<mimic joint="other"/>')
    other = joint("other", "l1", "l5", more='<mimic joint="lift"/>')
    with pytest.raises(UserError, match="'level' follows 'lift'"):
        robot_from_urdf(
            urdf(*CHAIN[:2], through, other, tool, *LINKS, link("l4", 1), link("l5", 1))
        )


@pytest.mark.parametrize(
    ("mimic", "said"),
    [
        ("<mimic/>", "joint 'finger': found <mimic joint=None>"),
        ('<mimic joint="gone"/>', "joint 'finger': found <mimic joint='gone'>"),
        ('<mimic joint="lift" multiplier="x"/>', "found <mimic multiplier='x'>, expected a number"),
    ],
)
def test_who_follows_nobody_is_named(mimic, said, capfd):
    with pytest.raises(UserError, match=re.escape(said)):
        robot_from_urdf(urdf(*CHAIN[:2], joint("finger", "l2", "l3", more=mimic), *LINKS))
    assert capfd.readouterr() == ("", "")  # the parser's own words stay away


def test_joints_of_a_simulator_s_part_are_none_of_the_arm():
    loop = (
        '<gazebo><joint name="loop" type="revolute"><parent>l3</parent><child>base</child>'
        "<axis><xyz>0 1 0</xyz></axis></joint></gazebo>"
    )
    assert robot_from_urdf(urdf(*CHAIN, *LINKS, loop)).joint_names == ("pan", "lift", "roll")


@pytest.mark.parametrize(
    ("declared", "encoding"),
    [("UTF-16", "utf-16"), ("ISO-8859-1", "latin-1"), ("UTF-8", "utf-8-sig"), ("", "utf-16")],
)
def test_letters_are_as_the_file_says(tmp_path, declared, encoding):
    head = f'<?xml version="1.0" encoding="{declared}"?>\n' if declared else ""
    text = head + urdf(*CHAIN, *LINKS).replace('"arm"', '"Ärmchen"')
    (tmp_path / "arm.urdf").write_bytes(text.encode(encoding))
    assert robot_from_urdf(tmp_path / "arm.urdf").name == "Ärmchen"
    assert reduced_model(tmp_path / "arm.urdf", None).nq == 3


def test_a_blank_line_above_the_declaration_and_a_wrong_encoding(tmp_path):
    (tmp_path / "arm.urdf").write_text("\n" + '<?xml version="1.0"?>' + urdf(*CHAIN, *LINKS))
    assert robot_from_urdf(tmp_path / "arm.urdf").n == 3
    (tmp_path / "arm.urdf").write_text('<?xml version="1.0" encoding="nix"?>' + urdf())
    with pytest.raises(UserError, match=r"not well-formed XML: unknown encoding"):
        robot_from_urdf(tmp_path / "arm.urdf")


@pytest.mark.parametrize("address", ["http://wiki.ros.org/xacro", "https://www.ros.org/wiki/xacro"])
def test_xacro_by_whatever_address(address):
    text = urdf('<xacro:property name="m" value="1"/>', *CHAIN, *LINKS)
    with pytest.raises(UserError, match="a xacro file"):
        robot_from_urdf(text.replace("<robot", f'<robot xmlns:xacro="{address}"'))


def test_drives_have_the_limits_of_their_own_joint(tmp_path):
    """Whatever the file's order is, and whatever else is called a joint in it."""
    follows = joint("finger", "l3", "l4", more='<mimic joint="roll"/>')
    fast = CHAIN[0].replace('velocity="2"', 'velocity="7"')
    parts = urdf(*reversed((fast, *CHAIN[1:])), follows, *LINKS, link("l4", 1))
    (tmp_path / "arm.urdf").write_text(parts)
    drives = ", ".join(f"{{node: {k}, counts_per_rev: 1000, rated_torque: 1}}" for k in range(1, 4))
    (tmp_path / "arm.yaml").write_text(f"urdf: arm.urdf\ndrives: [{drives}]\n")
    profile = load_profile(tmp_path / "arm.yaml")
    assert robot_from_profile(profile).velocity.tolist() == [7, 2, 2]
    assert [one.velocity for one in axis_limits(profile)] == [7, 2, 2]


def test_blanks_around_numbers_change_nothing(tmp_path, capfd):
    """Pinocchio's parser leaves a body out whose mass or inertia ends with a blank."""
    plain = robot_from_urdf(urdf(*LINKS, *CHAIN))
    wide = re.sub(r'(\w+)="([-\d. ]+)"', r'\1=" \2\n"', urdf(*LINKS, *CHAIN))
    robot = robot_from_urdf(wide)
    np.testing.assert_array_equal(robot.parameters, plain.parameters)
    np.testing.assert_array_equal(robot.axis, plain.axis)
    np.testing.assert_array_equal(robot.effort, plain.effort)
    (tmp_path / "arm.urdf").write_text(wide)
    (tmp_path / "plain.urdf").write_text(urdf(*LINKS, *CHAIN))
    of_plant, as_plain = (reduced_model(tmp_path / f"{n}.urdf", None) for n in ("arm", "plain"))
    for one, other in zip(of_plant.inertias, as_plain.inertias, strict=True):
        np.testing.assert_array_equal(one.toDynamicParameters(), other.toDynamicParameters())
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("axis", ["0\u00a00\u00a01", "0 0 \u0661"])
def test_numbers_are_written_in_ascii(axis):
    with pytest.raises(UserError, match="expected three numbers"):
        robot_from_urdf(urdf(*LINKS, *CHAIN[1:], joint("pan", "base", "l1", axis=axis)))


def test_a_chain_without_end_is_refused_in_one_line():
    links = [link(f"k{k}", 1) for k in range(1200)]
    joints = [joint(f"j{k}", f"k{k - 1}" if k else "base", f"k{k}") for k in range(1200)]
    with pytest.raises(UserError, match="found 1200 joints, expected 500 at most"):
        robot_from_urdf(urdf(*links, *joints))


@pytest.mark.parametrize(
    ("written", "speed", "torque"),
    [
        (LIMIT, 2, 10),
        ('<limit lower="-3" upper="3" effort="10" velocity="10000"/>', np.inf, 10),
        ('<limit lower="-3" upper="3" effort="1e9" velocity="2"/>', 2, np.inf),
        ('<limit lower="-3" upper="3" velocity="2"/>', 2, np.inf),
        ('<limit lower="-3" upper="3"/>', np.inf, np.inf),
    ],
)
def test_limits_that_say_nothing_are_unknown(tmp_path, written, speed, torque):
    """Left out, or a number that stands for none: no plan may take it for a speed."""
    file = tmp_path / "arm.urdf"
    file.write_text(urdf(*CHAIN, *LINKS).replace(LIMIT, written))
    robot = robot_from_urdf(file)
    np.testing.assert_array_equal(robot.velocity, speed)
    np.testing.assert_array_equal(robot.effort, torque)
    drives = ", ".join(f"{{node: {k}, counts_per_rev: 1000, rated_torque: 1}}" for k in range(1, 4))
    (tmp_path / "arm.yaml").write_text(f"urdf: arm.urdf\ndrives: [{drives}]\n")
    for limit in axis_limits(load_profile(tmp_path / "arm.yaml")):
        assert (limit.velocity, limit.torque, limit.lower) == (speed, torque, -3)
    assert len(list(reduced_model(file, None).names)) == 4


def test_a_prefix_that_nothing_declares():
    """As simulators' parts of a file have it, and ROS's own parser takes it."""
    camera = '<gazebo reference="l1"><sensor:camera name="eye"/></gazebo>'
    robot = robot_from_urdf(urdf(*CHAIN, *LINKS, camera))
    assert robot.joint_names == ("pan", "lift", "roll")
    with pytest.raises(UserError, match="a xacro file"):
        robot_from_urdf(urdf(*CHAIN, *LINKS, '<xacro:arm side="left"/>'))
