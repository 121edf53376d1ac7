"""URDFs as makers write them: joints from the tip, names that joints and links share."""

from __future__ import annotations

import numpy as np
import pytest

from backends.virtual.plant.arm import reduced_model
from pa10d.dynamics import inverse_dynamics, robot_from_urdf

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
