"""Tuning a profile: what is in force, what is asked before it is written, and undo."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.common.yamlfile import read_yaml
from pa10d.control.joint_figures import MEASURED, presumed_figures
from pa10d.profile import load_profile
from pa10d.services.joints import keep_learnt, kept_joints, learnt
from pa10d.services.profile_file import rewritten
from pa10d.services.robots import load_robot
from pa10d.services.tuning import (
    own_profile,
    propose,
    show,
    undo,
    versions,
    why_not_held,
    write,
)
from pa10d.services.tuning.told import TuningBound
from pa10d.services.tuning.versions import folder_of, write_version

LINK = '<link name="l{0}"><inertial><origin xyz="0 0 -0.2"/><mass value="3"/><inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.01"/></inertial></link>'  # noqa: E501
JOINT = '<joint name="j{0}" type="revolute"><parent link="{1}"/><child link="l{0}"/><origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="40" velocity="1.5"/></joint>'  # noqa: E501
PROFILE = """\
# Two joints.   Odd   spacing stays.
urdf: robot.urdf  # beside this file
limits:
  velocity:
    - 1.0  # the first, with care
    - 1.2
  acceleration: [ 3,3 ]  # assumed
  # torque: the URDF's
environment: {floor: -1.5}   # a pit

control:
  rate: 500
# the end
"""


@pytest.fixture
def arm(tmp_path):
    parts = [JOINT.format(k, f"l{k - 1}" if k > 1 else "base") + LINK.format(k) for k in (1, 2)]
    text = f'<robot name="arm"><link name="base"/>{"".join(parts)}</robot>'
    (tmp_path / "robot.urdf").write_text(text)
    path = tmp_path / "arm.yaml"
    path.write_text(PROFILE)
    return path


@pytest.fixture
def data(tmp_path):
    return tmp_path / "data"


def sentences(found):
    return [one.sentence for one in found.diff if one.asked]


def in_force(data, arm, name):
    return next(one for one in show(data, arm).values if one.key == name)


def test_what_is_in_force_says_where_it_comes_from(arm, data):
    speed = in_force(data, arm, "limits.velocity")
    assert (speed.in_force, speed.source) == ([1, 1.2], "profile")
    assert speed.bounds == [TuningBound("the URDF's", [1.5, 1.5])]
    torque = in_force(data, arm, "limits.torque")
    assert (torque.in_force, torque.source, torque.written) == ([40, 40], "URDF", None)
    assert in_force(data, arm, "control.bandwidth_hz").in_force == 4
    assert in_force(data, arm, "control.gains.kp").units == ["N·m/rad"] * 2


def test_a_change_is_shown_before_it_is_written(arm, data):
    changes = {"limits.velocity": {"2": 0.8}, "control.bandwidth_hz": 3}
    found = propose(data, arm, changes)
    assert sentences(found) == [
        "bandwidth: 4 Hz → 3 Hz",
        "velocity of joint 2: 1.2 rad/s → 0.8 rad/s",
    ]
    followed = {one.key for one in found.diff if not one.asked}
    assert followed == {"control.gains.kp", "control.gains.ki", "control.gains.kd"}
    assert (found.version, found.confirm, found.restart) == (2, [], True)
    assert arm.read_text() == PROFILE
    assert sorted(p.name for p in arm.parent.iterdir() if p.name.startswith(".")) == []


def test_the_file_keeps_its_comments_and_undo_every_byte(arm, data):
    changes = {
        "limits.velocity": {"2": 0.8},
        "limits.torque": [30, 20],
        "control.gains.kp": [1000, 500],
        "environment.boxes": [{"name": "table", "size": [1, 1, 0.5], "xyz": [1, 0, 0.25]}],
    }
    assert write(data, arm, changes, confirmed=True).written
    text = arm.read_text()
    new = {"    - 0.8", "  torque: [30, 20]", "  gains:", "    kp: [1000, 500]"}
    lines = set(text.splitlines())
    assert new <= lines
    assert set(PROFILE.splitlines()) - lines == {
        "    - 1.2",
        "environment: {floor: -1.5}   # a pit",
    }
    assert "xyz: [1, 0, 0.25]}]}   # a pit" in text
    profile = load_profile(arm)
    assert profile.limits.velocity == [1.0, 0.8]
    assert profile.environment.boxes[0].name == "table"

    write(data, arm, {"limits.velocity": {"1": 0.5}})
    assert [(v.version, v.undone) for v in versions(data, arm)] == [(3, False), (2, False)]
    assert show(data, arm).version == 3
    assert sentences(undo(data, arm, check=True)) == ["velocity of joint 1: 0.5 rad/s → 1 rad/s"]
    assert undo(data, arm).version == 2
    assert arm.read_text() == text
    undo(data, arm, confirmed=True)
    assert arm.read_text() == PROFILE
    with pytest.raises(UserError, match="nothing to undo"):
        undo(data, arm)
    assert [v.undone for v in versions(data, arm)] == [True, True]
    assert write(data, arm, {"control.bandwidth_hz": 3}).version == 4  # none is given twice
    assert undo(data, arm).version == 1


def test_undo_does_not_lose_what_was_edited_by_hand(arm, data):
    write(data, arm, {"control.bandwidth_hz": 3})
    arm.write_text(arm.read_text() + "name: mine\n")
    with pytest.raises(UserError, match="edited by hand since"):
        undo(data, arm)
    assert load_profile(arm).name == "mine"


NAN = float("nan")


@pytest.mark.parametrize(
    ("changes", "wrong"),
    [
        ({"limits.velocity": {"2": -1}}, r"limits.velocity.2: found -1, expected a number above 0"),
        (
            {"limits.velocity": [1, 2, 3]},
            r"limits.velocity: found 3 entries, expected 2, one per joint",
        ),
        ({"limits.position": {"1": [1, -1]}}, r"limits.position.1: found .* lower and upper"),
        ({"limits.velocty": [1, 2]}, r"not tuned here; .*did you mean limits.velocity"),
        ({"limits.velocity": {"3": 1}}, r"found joint '3', expected 1 to 2"),
        ({"control.bandwidth_hz": {"1": 3}}, r"expected one value"),
        ({"control.bandwidth_hz": 9}, r"control.bandwidth_hz: found 9.* at most 5"),
        ({"control.gains.kp": "much"}, r"control.gains.kp: found 'much', expected a list"),
        ({"environment.boxes": [{"size": [1, 1, 1]}]}, r"boxes.1.xyz: found nothing"),
        ({"limits.velocity": [1.0, 1.2]}, r"nothing to change"),
        ({"limits.velocity": {"2": NAN}}, r"^limits.velocity.2: found nan, expected a finite num"),
        ({"limits.velocity": [1.0, NAN]}, r"^limits.velocity.2: found nan, expected a finite num"),
        ({"control.bandwidth_hz": NAN}, r"^control.bandwidth_hz: found nan, expected a finite num"),
        ({"environment.boxes": [{"size": [1, NAN, 1]}]}, r"^environment.boxes.1.size.2: found nan"),
    ],
)
def test_a_bad_value_is_one_line_and_writes_nothing(arm, data, changes, wrong):
    with pytest.raises(UserError, match=wrong) as error:
        write(data, arm, changes, confirmed=True)
    assert len(str(error.value).splitlines()) == 1
    assert ".new.yaml" not in str(error.value)
    assert arm.read_text() == PROFILE
    assert versions(data, arm) == []


@pytest.mark.parametrize(
    ("changes", "asked"),
    [
        (
            {"limits.velocity": {"1": 1.6}},
            "joint 1: velocity of 1.6 rad/s goes beyond the URDF's 1.5",
        ),
        ({"limits.torque": {"2": 41}}, "joint 2: torque of 41 N·m goes beyond the URDF's 40"),
        (
            {"limits.position": {"1": [-2.1, 2]}},
            "lower position of -2.1 rad goes beyond the URDF's -2",
        ),
        ({"limits.acceleration": {"1": 4}}, "instead of 3: neither the URDF nor a drive"),
        (
            {"safety.following_error": {"1": 0.3}},
            "following error of 0.3 rad goes beyond the usual",
        ),
        ({"environment.floor": None}, "no floor instead of -1.5 m"),
        ({"control.gains.kp": {"1": 4e3}}, "more than 3 swings for long"),
    ],
)
def test_what_lets_the_arm_do_more_is_to_be_confirmed(arm, data, changes, asked):
    (said,) = propose(data, arm, changes).confirm
    assert asked in said
    with pytest.raises(UserError, match="to be confirmed"):
        write(data, arm, changes)
    assert arm.read_text() == PROFILE
    assert write(data, arm, changes, confirmed=True).written


UNSTABLE = "joint 1: the gains that the profile states make a loop that is not stable"


def test_gains_that_enable_refuses_are_not_confirmed_either(arm, data):
    changes = {"control.gains.kp": {"1": 1e6}}
    for ask in (propose, write):
        with pytest.raises(UserError, match=UNSTABLE) as refusal:
            ask(data, arm, changes, **({"confirmed": True} if ask is write else {}))
    stated = {"kp": [1e6, in_force(data, arm, "control.gains.kp").in_force[1]]}
    assert str(refusal.value) == f"{arm}: {why_not_held(str(data), str(arm), stated)}"
    assert arm.read_text() == PROFILE


def test_unstable_gains_written_by_hand_are_mended_joint_by_joint(arm, data):
    ruled = in_force(data, arm, "control.gains.kp").in_force
    arm.write_text(PROFILE.replace("  rate: 500", "  rate: 500\n  gains: {kp: [1.0e+6, 1.0e+6]}"))
    assert write(data, arm, {"environment.floor": -1.6}, confirmed=True).written
    assert write(data, arm, {"control.gains.kp": {"1": ruled[0]}}).written
    with pytest.raises(UserError, match="joint 2: the gains that the profile states"):
        write(data, arm, {"control.gains.kp": {"2": 2e6}}, confirmed=True)
    with pytest.raises(UserError, match=UNSTABLE):
        undo(data, arm, confirmed=True)


def test_a_limit_beyond_the_urdfs_keeps_its_sign(arm, data):
    urdf = arm.with_name("robot.urdf")
    urdf.write_text(urdf.read_text().replace('upper="2"', 'upper="-0.0698"'))
    (said,) = propose(data, arm, {"limits.position": {"1": [-2, -0.02]}}).confirm
    assert said == "joint 1: upper position of -0.02 rad goes beyond the URDF's -0.0698"


def test_a_limit_that_the_urdf_writes_with_fewer_digits_is_not_beyond_it(arm, data):
    urdf = arm.with_name("robot.urdf")
    urdf.write_text(urdf.read_text().replace('velocity="1.5"', 'velocity="3.14159265"'))
    assert propose(data, arm, {"limits.velocity": {"1": 3.141592654}}).confirm == []


def test_a_limit_that_goes_is_said_in_words(arm, data):
    urdf = arm.with_name("robot.urdf")
    free = urdf.read_text().replace('type="revolute"', 'type="continuous"', 1)
    urdf.write_text(free.replace('lower="-2" upper="2" ', "", 1))
    write(data, arm, {"limits.position": {"1": [-1, 1]}})
    found = undo(data, arm, check=True)
    assert "position of joint 1: -1 to 1 rad → none" in [one.sentence for one in found.diff]
    assert found.confirm[0].startswith("joint 1: no lower position instead of -1: neither")


TABLE = {"name": "table", "size": [1, 1, 0.5], "xyz": [1, 0, 0.25]}


@pytest.mark.parametrize(
    ("boxes", "confirm"),
    [
        ([TABLE | {"name": "bench"}], []),
        ([TABLE | {"size": [1, 1.2, 0.5]}], []),
        ([TABLE | {"size": [1, 1, 0.6], "xyz": [1, 0, 0.3]}], []),
        (
            [TABLE | {"size": [1, 1, 0.6], "xyz": [1, 0, 0.4]}],
            ["table changed: motions may go where it was"],
        ),
        ([TABLE | {"size": [1, 0.9, 0.5]}], ["table changed: motions may go where it was"]),
        ([TABLE | {"rpy": [0, 0, 1]}], ["table changed: motions may go where it was"]),
        ([], ["table is gone: motions may go where it was"]),
    ],
)
def test_only_a_box_that_leaves_room_is_to_be_confirmed(arm, data, boxes, confirm):
    write(data, arm, {"environment.boxes": [TABLE]})
    assert propose(data, arm, {"environment.boxes": boxes}).confirm == confirm


def test_raising_within_what_the_urdf_allows_and_lowering_ask_nothing(arm, data):
    found = propose(data, arm, {"limits.velocity": [1.5, 1.0], "environment.floor": -1})
    assert found.confirm == []


def test_undo_asks_as_any_change_does(arm, data):
    arm.write_text(PROFILE.replace("- 1.2", "- 1.7"))
    write(data, arm, {"limits.velocity": {"2": 1.0}})
    with pytest.raises(UserError, match=r"goes beyond the URDF's 1\.5"):
        undo(data, arm)
    assert undo(data, arm, confirmed=True).written


def test_a_shipped_profile_is_tuned_in_a_copy(data):
    before = own_profile(data, "pa10-sim")
    assert propose(data, "pa10-sim", {"control.bandwidth_hz": 3}).file.startswith(str(data))
    assert own_profile(data, "pa10-sim") == before
    text = before.read_text()
    write(data, "pa10-sim", {"control.bandwidth_hz": 3})
    copy = own_profile(data, "pa10-sim")
    assert copy == data / "profiles" / "pa10-sim.yaml"
    assert before.read_text() == text
    profile, robot = load_robot(copy)
    assert (profile.control.bandwidth_hz, robot.n) == (3, 7)
    undo(data, "pa10-sim")
    assert load_profile(copy).control.bandwidth_hz is None


def test_a_urdf_alone_is_shown_but_not_tuned(arm, data):
    urdf = arm.with_name("robot.urdf")
    assert "cannot be tuned" in show(data, urdf).refusal
    with pytest.raises(UserError, match="pa10d profile new"):
        write(data, urdf, {"control.bandwidth_hz": 3})


def test_measured_joints_hold_for_the_arm_tuned_otherwise(arm, data):
    profile, robot = load_robot(arm)
    figures = presumed_figures(robot).but(coulomb=np.array([2.0, 1.0]), doubt=np.full(2, MEASURED))
    kept = keep_learnt(data, profile, ["r"], learnt(profile, robot, figures))
    assert in_force(data, arm, "control.gains.kp").source == "measured"
    found = write(data, arm, {"control.bandwidth_hz": 2, "safety.following_error": [0.1, 0.1]})
    now = kept_joints(data, load_profile(arm))
    assert now.measured == kept.measured
    assert now.known.figures.document() == kept.known.figures.document()
    shown = in_force(data, arm, "control.gains.kp").in_force
    assert shown == pytest.approx(now.known.gains.kp)
    assert shown[0] < kept.known.gains.kp[0]
    new = [one.new for one in found.diff if one.key == "control.gains.kp"]
    assert new == pytest.approx(shown)


DRIVES = """\
drives:
  - {node: 1, counts_per_rev: 4096, rated_torque: 50}
  - {node: 2, counts_per_rev: 4096, rated_torque: 50}
"""


def test_figures_measured_in_another_scale_of_torques_are_not_taken_along(arm, data):
    arm.write_text(PROFILE + DRIVES)
    plain, robot = load_robot(arm)
    figures = presumed_figures(robot).but(coulomb=np.array([2.0, 1.0]), doubt=np.full(2, MEASURED))
    keep_learnt(data, plain, ["plain"], learnt(plain, robot, figures))
    text = (PROFILE + DRIVES).replace("node: 2,", "node: 2, torque_gain: 1.25,")
    write_version(folder_of(data, arm), ["gain"], arm, PROFILE + DRIVES, text, None)
    assert kept_joints(data, load_profile(arm)) is None
    heavier = figures.but(coulomb=np.array([9.0, 9.0]))
    scaled = load_profile(arm)
    keep_learnt(data, scaled, ["scaled"], learnt(scaled, robot, heavier))
    found = undo(data, arm)
    assert (found.restart, found.confirm) == (True, [])
    assert sentences(found) == ["torque gain of joint 2: 1.25 → 1"]
    assert kept_joints(data, load_profile(arm)).runs == ("plain",)


def test_a_joint_without_limits_is_told_and_asked_for(arm, data):
    urdf = arm.with_name("robot.urdf")
    urdf.write_text(urdf.read_text().replace('"revolute"', '"continuous"'))
    assert in_force(data, arm, "limits.position").in_force == [[None, None]] * 2
    with pytest.raises(UserError, match=r"limits.position: found no joint 2, .* expected one, too"):
        propose(data, arm, {"limits.position": {"1": [-1, 1]}})
    found = propose(data, arm, {"limits.position": {"1": [-1, 1], "2": [-2, 2]}})
    assert sentences(found)[0] == "position of joint 1: none → -1 to 1 rad"


def test_a_disk_that_is_full_refuses_the_whole_change(arm, data, monkeypatch):
    plain, robot = load_robot(arm)
    keep_learnt(data, plain, ["plain"], learnt(plain, robot, presumed_figures(robot)))

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pa10d.services.joints.write_json", full)
    with pytest.raises(OSError, match="No space"):
        write(data, arm, {"limits.velocity": [0.5, 0.5]})
    assert arm.read_text() == PROFILE
    assert versions(data, arm) == []


FASTER = {"limits.velocity": {"1": 0.9}}
SLOWER = {"limits.velocity": {"1": 0.5}}


@pytest.mark.parametrize(
    "damage", [b"{", b"", b'{"schema": "pa10d/profile-version/1"}', b"\xff\x00"]
)
def test_a_damaged_version_is_named_and_everything_else_goes_on(arm, data, damage):
    write(data, arm, {"limits.velocity": [0.5, 0.5]})
    kept = arm.read_text()
    write(data, arm, {"limits.velocity": [0.4, 0.4]})
    [first, second] = sorted(folder_of(data, arm).glob("0*.json"))
    whole = second.read_bytes()
    second.write_bytes(damage)
    assert show(data, arm).values
    [lost, known] = versions(data, arm)
    assert (lost.version, lost.undone, known.version) == (3, True, 2)
    assert lost.changes[0].startswith(f"cannot be read: {second}: ")
    with pytest.raises(UserError, match=r"version 3 cannot be read: .*expected an edit"):
        undo(data, arm)
    assert write(data, arm, {"limits.velocity": [0.3, 0.3]}).version == 4
    undo(data, arm)
    second.write_bytes(whole)
    undo(data, arm)
    assert arm.read_text() == kept
    first.write_bytes(damage)
    with pytest.raises(UserError, match="version 2 cannot be read"):
        undo(data, arm)


@pytest.fixture
def cut_short(monkeypatch):
    """What is given as ``call`` comes no further than to this function: the process is gone."""

    def cut(function, call, *arguments):
        with monkeypatch.context() as patch:
            patch.setattr(sys.modules[folder_of.__module__], function, lambda *_: None)
            call(*arguments)

    return cut


@pytest.mark.parametrize("profile", ["arm", "pa10-sim"])
def test_a_change_that_never_reached_the_file_is_none(arm, data, cut_short, profile):
    name = arm if profile == "arm" else profile
    cut_short("put_profile", write, data, name, SLOWER)
    assert show(data, name).version == 1
    assert [one.undone for one in versions(data, name)] == [True]
    with pytest.raises(UserError, match="nothing to undo"):
        undo(data, name)
    assert write(data, name, FASTER).version == 3
    assert [(one.version, one.undone) for one in versions(data, name)] == [
        (3, False), (2, True),
    ]  # fmt: skip
    undo(data, name)
    assert show(data, name).version == 1


def test_changes_before_one_that_was_cut_short_can_be_undone(arm, data, cut_short):
    write(data, arm, FASTER)
    cut_short("put_profile", write, data, arm, SLOWER)
    assert show(data, arm).version == 2
    undo(data, arm)
    assert arm.read_text() == PROFILE
    assert (show(data, arm).version, {one.undone for one in versions(data, arm)}) == (
        1,
        {True},
    )


def test_an_undo_that_was_cut_short_is_one(arm, data, cut_short):
    write(data, arm, FASTER)
    write(data, arm, SLOWER)
    cut_short("_store", undo, data, arm)
    assert show(data, arm).version == 2
    undo(data, arm)
    assert arm.read_text() == PROFILE


@pytest.mark.parametrize(
    ("text", "data", "expected"),
    [
        ("{a: 1, b: {c: 2}}\n", {"a": 1, "b": {"c": 2, "d": [3]}}, "{a: 1, b: {c: 2, d: [3]}}\n"),
        ("a: {}  # x\n", {"a": {"b": 1}}, "a: {b: 1}  # x\n"),
        ("a:  # x\nb: 1", {"a": {"c": 1}, "b": 1}, "a: {c: 1}  # x\nb: 1"),
        ("a:\n- 1\n- 2 # y\n", {"a": [1, 3]}, "a:\n- 1\n- 3 # y\n"),
        ("a:\n- 1\n- 2\nb: 1\n", {"a": [1], "b": 1}, "a:\n  [1]\nb: 1\n"),
        ("a:\r\n  b: 1\r\n", {"a": {"b": 2}}, "a:\r\n  b: 2\r\n"),
        ("a: 1", {"a": 1, "b": {"c": {"d": 1}}}, "a: 1\nb:\n  c:\n    d: 1\n"),
    ],
)
def test_values_change_where_they_stand(tmp_path, text, data, expected):
    path = tmp_path / "f.yaml"
    path.write_bytes(text.encode())
    assert rewritten(read_yaml(path), data) == expected


def test_what_cannot_be_edited_safely_is_left(arm, data):
    text = PROFILE.replace("acceleration: [ 3,3 ]", "acceleration: &a [ 3,3 ]")
    arm.write_text(text + "safety: {following_error: *a}\n")
    with pytest.raises(UserError, match="cannot be edited safely"):
        write(data, arm, {"limits.acceleration": {"1": 2}})
    assert arm.read_text().startswith(text)


def test_a_gain_of_one_joint_states_those_of_all_others_and_says_so(arm, data):
    """The bandwidth, lowered later, left joint 2's kp where it was and took its kd away."""
    shown = in_force(data, arm, "control.gains.kp").in_force
    found = propose(data, arm, {"control.gains.kp": {"1": round(0.95 * shown[0], 3)}})
    (said,) = (one for one in found.effect if "stated" in one)
    assert said.endswith(
        "of joint 2 is stated, too, as it is in force: from now on it does not follow the bandwidth"
    )
    both = {"control.gains.kp": {str(j + 1): round(0.95 * v, 3) for j, v in enumerate(shown)}}
    assert not [one for one in propose(data, arm, both).effect if "stated" in one]
    assert not [
        one for one in propose(data, arm, {"limits.velocity": {"2": 0.8}}).effect if "stated" in one
    ]
