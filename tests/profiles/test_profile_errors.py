"""One broken profile per message: each is one line with file, line, key, found and expected."""

from __future__ import annotations

import pytest

from pa10d.common.errors import UserError
from pa10d.profile import load_profile

URDF = '<robot name="r"><link name="a"/></robot>'
HEAD = "urdf: robot.urdf\n"
BOX = "{size: [1, 1, 1], xyz: [0, 0, 0]}"
DRIVE = "{node: 1, counts_per_rev: 1000, rated_torque: 1}"

BROKEN = {
    "unknown key": (HEAD + "gaer: 50\n", 2, "gaer", "an unknown key", "one of name, urdf, joints"),
    "misspelt key": (
        HEAD + "limits:\n  velocty: [1]\n",
        3, "limits.velocty", "an unknown key", "'velocity'",
    ),
    "misspelt key in a list": (
        HEAD + f"drives:\n  - {DRIVE}\n  - {{counts: 5, {DRIVE[1:]}\n",
        4, "drives.2.counts", "an unknown key", "'counts_per_rev'",
    ),
    "no urdf": ("name: arm\n", 1, "urdf", "nothing", "the path of a URDF file"),
    "urdf is a number": ("urdf: 7\n", 1, "urdf", "7", "the path of a URDF file"),
    "urdf does not exist": ("name: x\nurdf: no.urdf\n", 2, "urdf", "'no.urdf'", "an existing file"),
    "path given": (HEAD + "path: x\n", 2, "path", "an unknown key", "'urdf'"),
    "name is a number": (HEAD + "name: 7\n", 2, "name", "7", "text"),
    "joints are text": (HEAD + "joints: S1\n", 2, "joints", "'S1'", "a list"),
    "joint twice": (HEAD + "joints: [a, b, a]\n", 2, "joints.3", "'a'", "joint names that differ"),
    "no joints": (HEAD + "joints: []\n", 2, "joints", "0 entries", "at least one entry"),
    "base and gravity": (
        HEAD + "base: {rpy: [0, 0, 0]}\ngravity: [0, 0, -9.81]\n",
        3, "gravity", "(0.0, 0.0, -9.81)", "either 'base' or 'gravity', not both",
    ),
    "short vector": (HEAD + "gravity: [0, -9]\n", 2, "gravity", "[0, -9]", "a list of 3 numbers"),
    "vector is text": (HEAD + "base: {rpy: up}\n", 2, "base.rpy", "'up'", "a list of 3 numbers"),
    "no number in vector": (
        HEAD + "gravity: [0, 0, down]\n", 2, "gravity.3", "'down'", "a number",
    ),
    "floor is a word": (
        HEAD + "environment: {floor: low}\n",
        2, "environment.floor", "'low'", "a height in m, or none",
    ),
    "box without a place": (
        HEAD + "environment:\n  boxes:\n    - {size: [1, 1, 1]}\n",
        4, "environment.boxes.1.xyz", "nothing", "a value",
    ),
    "box without extent": (
        HEAD + "environment:\n  boxes:\n    - {size: [1, 0, 1], xyz: [0, 0, 0]}\n",
        4, "environment.boxes.1.size", "[1, 0, 1]", "three lengths in m, all above 0",
    ),
    "box with a misspelt key": (
        HEAD + "environment:\n  boxes:\n    - {size: [1, 1, 1], xyz: [0, 0, 0], rpj: [0, 0, 0]}\n",
        4, "environment.boxes.1.rpj", "an unknown key", "'rpy'",
    ),
    "boxes are one box": (
        HEAD + "environment: {boxes: {size: [1, 1, 1]}}\n",
        2, "environment.boxes", "{'size': [1, 1, 1]}", "a list",
    ),
    "section is a number": (HEAD + "can: 5\n", 2, "can", "5", "a section of keys and values"),
    "number is text": (HEAD + "control: {rate: fast}\n", 2, "control.rate", "'fast'", "a number"),
    "number is true": (HEAD + "control: {rate: yes}\n", 2, "control.rate", "True", "a number"),
    "rate too high": (HEAD + "control:\n  rate: 5000\n", 3, "control.rate", "5000", "at most 2000"),
    "rate zero": (HEAD + "control:\n  rate: 0\n", 3, "control.rate", "0", "a number above 0"),
    "rate too low": (HEAD + "control: {rate: 1}\n", 2, "control.rate", "1", "at least 20"),
    "deaf": (
        HEAD + "safety: {stale_cycles: 251}\n",
        2, "safety.stale_cycles", "251", "at most 250: 0.5 s at 500 Hz",
    ),
    "as good as no following error": (
        HEAD + "safety: {following_error: [1e9]}\n",
        2, "safety.following_error.1", "1000000000.0", "at most 3.2",
    ),
    "too fast": (
        HEAD + "limits: {velocity: [1e9]}\n", 2, "limits.velocity.1", "1000000000.0", "at most",
    ),
    "too strong": (
        HEAD + "limits: {torque: [1e9]}\n", 2, "limits.torque.1", "1000000000.0", "at most",
    ),
    "gear in counts": (
        HEAD + "drives: [{node: 1, counts_per_rev: 4096, gear_ratio: 1e9, rated_torque: 1}]\n",
        2, "drives.1.gear_ratio", "1000000000.0", "at most",
    ),
    "encoder of one count": (
        HEAD + "drives: [{node: 1, counts_per_rev: 1, rated_torque: 1}]\n",
        2, "drives.1.counts_per_rev", "1", "at least 100",
    ),
    "not finite": (HEAD + "gravity: [0, 0, .inf]\n", 2, "gravity.3", "inf", "a finite number"),
    "unknown controller": (
        HEAD + "control: {controller: lqr}\n",
        2, "control.controller", "'lqr'", "'pid' or 'computed_torque'",
    ),
    "negative gain": (
        HEAD + "control: {gains: {ki: [-1]}}\n", 2, "control.gains.ki.1", "-1", "at least 0",
    ),
    "nobody notices that we died": (
        HEAD + f"drives: [{DRIVE[:-1]}, heartbeat_ms: 60000}}]\n",
        2, "drives.1.heartbeat_ms", "60000", "at most 200",
    ),
    "mounted in degrees": (
        HEAD + "base: {rpy: [180, 0, 0]}\n",
        2, "base.rpy.1", "180", "an angle in rad, of one turn at most",
    ),
    "box in degrees": (
        HEAD + "environment:\n  boxes: [{size: [1, 1, 1], xyz: [0, 0, 0], rpy: [0, 0, 45]}]\n",
        3, "environment.boxes.1.rpy.3", "45", "an angle in rad, of one turn at most",
    ),
    "boxes without end": (
        HEAD + f"environment:\n  boxes: [{', '.join([BOX] * 201)}]\n",
        3, "environment.boxes", "[{'size': [1, 1, 1], 'xyz': [0, 0, 0]}, {'size': [1, 1, 1...",
        "at most 200 entries",
    ),
    "node too large": (
        HEAD + "drives:\n  - {node: 200, counts_per_rev: 4096, rated_torque: 1}\n",
        3, "drives.1.node", "200", "at most 127",
    ),
    "node is broken": (
        HEAD + "drives: [{node: 1.5, counts_per_rev: 4096, rated_torque: 1}]\n",
        2, "drives.1.node", "1.5", "a whole number",
    ),
    "node twice": (
        HEAD + f"drives:\n  - {DRIVE}\n  - {DRIVE}\n",
        4, "drives.2.node", "1", "node ids that differ (drive 1)",
    ),
    "drive without torque": (
        HEAD + "drives: [{node: 1, counts_per_rev: 4096}]\n",
        2, "drives.1.rated_torque", "nothing", "a value; it has no default",
    ),
    "sign zero": (
        HEAD + "drives: [{node: 1, counts_per_rev: 4096, rated_torque: 1, sign: 0}]\n",
        2, "drives.1.sign", "0", "1 or -1",
    ),
    "brake is a number": (
        HEAD + "drives: [{node: 1, counts_per_rev: 4096, rated_torque: 1, brake: 3}]\n",
        2, "drives.1.brake", "3", "true or false",
    ),
    "eds does not exist": (
        HEAD + "drives: [{node: 1, counts_per_rev: 4096, rated_torque: 1, eds: a.eds}]\n",
        2, "drives.1.eds", "'a.eds'", "an existing file",
    ),
    "limits of other length": (
        HEAD + "joints: [a, b]\nlimits:\n  velocity: [1, 1, 1]\n",
        4, "limits.velocity", "3 entries", "2 entries, one per joint as in 'joints'",
    ),
    "gains of other length": (
        HEAD + f"drives: [{DRIVE}]\ncontrol: {{gains: {{kp: [1, 2]}}}}\n",
        3, "control.gains.kp", "2 entries", "1 entry, one per joint as in 'drives'",
    ),
    "limits the wrong way": (
        HEAD + "limits: {position: [[1, -1]]}\n",
        2, "limits.position.1", "[1, -1]", "lower and upper limit, the lower one first",
    ),
    "limits without room": (
        HEAD + "limits: {position: [[-1e-9, 1e-9]]}\n",
        2, "limits.position.1", "[-1e-09, 1e-09]", "limits that are at least 0.001 apart",
    ),
    "limit is one number": (
        HEAD + "limits: {position: [1]}\n", 2, "limits.position.1", "1", "a list of 2 numbers",
    ),
    "torque constant zero": (
        HEAD + "torque_constants: [1, 0]\n",
        2, "torque_constants.2", "0", "a number other than 0",
    ),
    "tool without mass": (HEAD + "tool: {com: [0, 0, 0]}\n", 2, "tool.mass", "nothing", "a value"),
    "impossible tool": (
        HEAD + "tool: {mass: 1, inertia: [1, 1, 5, 0, 0, 0]}\n",
        2, "tool.inertia", "[1, 1, 5, 0, 0, 0]", "a body that can exist",
    ),
    "bitrate too high": (
        HEAD + "can: {bitrate: 2000000}\n", 2, "can.bitrate", "2000000", "at most 1e+06",
    ),
    "channel is a number": (HEAD + "can: {channel: 0}\n", 2, "can.channel", "0", "text"),
    "servo too fast for its loop": (
        HEAD + "control: {rate: 20, bandwidth_hz: 0.8}\n",
        2, "control.bandwidth_hz", "0.8", "at most 0.2, a hundredth of the loop's rate",
    ),
    "plant is no factory": (
        HEAD + "simulation: {plant: my.plant}\n",
        2, "simulation.plant", "'my.plant'", "'package.module:factory'",
    ),
    "options are a list": (
        HEAD + "simulation: {options: [1]}\n",
        2, "simulation.options", "[1]", "a section of keys and values",
    ),
}  # fmt: skip


@pytest.fixture
def profile(tmp_path):
    (tmp_path / "robot.urdf").write_text(URDF)

    def write(text):
        path = tmp_path / "arm.yaml"
        path.write_text(text)
        return path

    return write


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_profile_gives_one_clear_line(profile, case):
    text, line, key, found, wanted = BROKEN[case]
    path = profile(text)
    with pytest.raises(UserError) as error:
        load_profile(path)
    message = str(error.value)
    assert "\n" not in message
    assert message.startswith(f"{path}:{line}: {key}: found {found}, expected ")
    assert wanted in message.split("expected ", 1)[1]


SYNTAX = {
    "empty": ("", ":1: found an empty file, expected lines 'key: value'"),
    "a list": ("- 1\n", ":1: found [1], expected lines 'key: value'"),
    "text": ("just words\n", ":1: found 'just words', expected lines"),
    "open bracket": ("urdf: robot.urdf\njoints: [a, b\nbase: {}\n", ":3: "),
    "tab": ("urdf: robot.urdf\ncan:\n\tbitrate: 5\n", ":3: found character '\\t'"),
    "key twice": (
        "urdf: robot.urdf\ncan: {}\nurdf: x\n",
        ":3: urdf: found a second time, expected once (first in line 1)",
    ),
    "unknown tag": ("urdf: !!python/object:os.system x\n", ":1: could not determine a constructor"),
}


@pytest.mark.parametrize("case", SYNTAX)
def test_broken_yaml_names_its_line(profile, case):
    text, said = SYNTAX[case]
    path = profile(text)
    with pytest.raises(UserError) as error:
        load_profile(path)
    message = str(error.value)
    assert message.startswith(f"{path}{said}")
    assert "\n" not in message
    assert "expected" in message


def test_bytes_that_are_no_text(profile, tmp_path):
    path = profile("")
    path.write_bytes(b"urdf: robot.urdf\nname: \xff\n")
    with pytest.raises(UserError, match=r"arm\.yaml: byte 24 is not UTF-8; expected text"):
        load_profile(path)


def test_several_problems_are_several_lines(profile):
    path = profile(HEAD + "joints: [a, a]\nlimits: {velocity: [1], torque: [1, 2, 3]}\n")
    with pytest.raises(UserError) as error:
        load_profile(path)
    lines = str(error.value).splitlines()
    assert len(lines) == 3
    assert all(line.startswith(f"{path}:") and ", expected " in line for line in lines)


def test_a_name_that_is_no_profile_lists_what_there_is():
    with pytest.raises(UserError, match=r"pa11: no such profile; expected .*pa10-7c, pa10-sim"):
        load_profile("pa11")


def test_numbers_with_an_exponent_and_no_dot_are_numbers(profile):
    assert load_profile(profile(HEAD + "control: {rate: 1e2}\n")).control.rate == 100.0


def test_a_urdf_line_is_a_whole_profile(profile):
    path = profile(HEAD)
    loaded = load_profile(path)
    assert (loaded.name, loaded.urdf) == ("arm", path.parent / "robot.urdf")


def test_a_urdf_alone_is_a_profile(profile):
    urdf = profile(HEAD).parent / "robot.urdf"
    assert (load_profile(urdf).name, load_profile(urdf).urdf) == ("robot", urdf)
