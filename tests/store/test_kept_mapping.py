"""An accepted mapping stays in the profile, which stays as its author wrote it."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.cli import main
from pa10d.common.errors import UserError
from pa10d.profile import load_profile
from pa10d.services import profile_file
from pa10d.services.kept_mapping import keep_mapping
from pa10d.services.profile_file import as_if_written, put_profile
from pa10d.services.tuning import undo, versions, write
from pa10d.store.column_mapping import Rule, Unit, read_mapping, read_unit, resolve

PROFILE = """\
# My arm.   Odd   spacing stays.
urdf: robot.urdf   # beside this file
limits: {velocity: [ 5.0 ]}

# the end
"""
MAP = ["stamp[ms]=time", "pos{n}[deg]=q", "trq{n}[-1]=tau"]


@pytest.fixture
def arm(shared_data, tmp_path):
    urdf = (shared_data / "bam_xl330" / "robot.urdf").read_text()
    (tmp_path / "robot.urdf").write_text(urdf)
    (tmp_path / "arm.yaml").write_text(PROFILE)
    t = np.arange(400) * 5.0
    q = 60 * np.sin(t / 300)
    table = np.column_stack([t, q, -0.4 * np.sin(np.radians(q))])
    file = tmp_path / "log.csv"
    np.savetxt(file, table, delimiter=",", header="stamp,pos1,trq1", comments="", fmt="%.12g")
    return tmp_path


def _import(folder, *more):
    words = ["run", "import", str(folder / "log.csv"), "--profile", str(folder / "arm.yaml")]
    return main(["--data", str(folder / "data"), *words, *more])


def test_once_accepted_the_next_import_needs_no_map(arm, capsys):
    assert _import(arm, "--name", "none") == 1
    assert "perhaps --map" in capsys.readouterr().err
    assert _import(arm, "--name", "a", "--map", *MAP) == 0
    assert "the mapping is kept in" in capsys.readouterr().err
    text = (arm / "arm.yaml").read_text()
    assert text.startswith(PROFILE)
    assert load_profile(arm / "arm.yaml").map == MAP
    assert _import(arm, "--name", "b") == 0
    assert _import(arm, "--name", "c", "--map", *MAP) == 0  # nothing new: nothing written
    assert (arm / "arm.yaml").read_text() == text


def test_what_is_said_now_goes_before_what_is_kept(arm):
    assert _import(arm, "--name", "a", "--map", *MAP) == 0
    assert _import(arm, "--name", "b", "--map", "pos{n}[rad]=q") == 0
    assert load_profile(arm / "arm.yaml").map == ["pos{n}[rad]=q", *MAP]


def test_a_kept_mapping_is_a_version_that_can_be_undone(arm):
    data, path = arm / "data", arm / "arm.yaml"
    write(data, path, {"limits.velocity": [4.0]})
    tuned = path.read_text()
    assert _import(arm, "--name", "a", "--map", *MAP) == 0
    [newest, _] = versions(data, path)
    assert newest.changes == [f"mapping: {' '.join(map(repr, MAP))}"]
    found = undo(data, path)
    assert [one.sentence for one in found.diff] == [f"mapping: {' '.join(MAP)} → none"]
    assert (found.restart, found.version) == (False, 2)
    assert path.read_text() == tuned
    undo(data, path)
    assert path.read_text() == PROFILE


def test_a_mapping_goes_to_the_profile_as_it_stands_by_then(arm):
    path = arm / "arm.yaml"
    before = load_profile(path)
    write(arm / "data", path, {"limits.velocity": [4.0]})
    keep_mapping(arm / "data", load_profile(path), MAP[:1])
    keep_mapping(arm / "data", before, MAP[1:])  # read before the two edits
    now = load_profile(path)
    assert (now.limits.velocity, now.map) == ([4.0], [*MAP[1:], MAP[0]])


def test_two_writers_of_one_profile_do_not_meet_in_a_draft(arm, monkeypatch):
    path, load = arm / "arm.yaml", profile_file.load_robot
    looked = []

    def meanwhile(draft):
        if not looked:
            looked.append(draft)
            as_if_written(path, PROFILE + "name: another\n")
        return load(draft)

    monkeypatch.setattr(profile_file, "load_robot", meanwhile)
    put_profile(path, PROFILE + "name: mine\n")
    assert looked
    assert load_profile(path).name == "mine"


def test_a_profile_that_is_not_ours_to_write_is_left_alone(arm, capsys):
    words = ["run", "import", str(arm / "log.csv"), "--profile", str(arm / "robot.urdf")]
    assert main(["--data", str(arm / "d"), *words, "--map", *MAP]) == 0
    assert "a URDF keeps no mapping; 'pa10d profile new" in capsys.readouterr().err


@pytest.mark.parametrize(
    "text",
    [
        "urdf: robot.urdf",
        "urdf: robot.urdf\nmap: []  # none\nname: x\n",
        "map: ['a=q1', 'b=tau1']   # two\nurdf: robot.urdf\n",
        "urdf: robot.urdf\nmap:\n  - a=q1  # one\n  - b=tau1\n\n# about limits\nlimits: {}\n",
        "\ufeffurdf: robot.urdf\nmap:\n- a=q1\nname: n\n",
    ],
)
def test_only_the_key_is_edited(arm, text):
    path = arm / "p.yaml"
    path.write_text(text, encoding="utf-8")
    before = load_profile(path)
    assert "the mapping is kept" in keep_mapping(arm / "data", before, MAP)
    assert load_profile(path).map == [*MAP, *(before.map or [])]
    kept = [
        line for line in text.lstrip("\ufeff").splitlines() if "=" not in line and "map" not in line
    ]
    assert [line for line in path.read_text().splitlines() if line in kept] == kept
    assert sorted(p.name for p in arm.iterdir() if p.name.startswith(".")) == []


def test_a_file_that_cannot_be_edited_stays(arm):
    path = arm / "p.yaml"
    path.write_text("urdf: robot.urdf\n...\n")
    assert "the mapping was not kept" in keep_mapping(arm / "data", load_profile(path), MAP)
    assert path.read_text() == "urdf: robot.urdf\n...\n"


def test_kept_rules_apply_where_their_columns_are():
    names = ["time", "pos1", "q1", "trq1"]
    kept = ["other{n}=q", "pos{n}[deg]=q", "q{n}=q", "trq{n}=tau"]
    found = resolve(read_mapping([], kept), names, 1, "file")
    assert found.fields == {"pos1": "q1", "trq1": "tau1"}
    found = resolve(read_mapping(["q1=q1"], kept), names, 1, "file")
    assert found.fields == {"q1": "q1", "trq1": "tau1"}
    with pytest.raises(UserError, match="no column 'other1'"):
        resolve([Rule("other1=q1", "other1", "q1")], names, 1, "file")


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("-1", Unit(-1.0)),
        ("0.01", Unit(0.01)),
        ("1/100", Unit(0.01)),
        ("-deg", Unit(-np.pi / 180)),
        ("deg/100", Unit(np.pi / 18000)),
        ("i16", Unit(1.0, 65536.0)),
        ("i16*0.5", Unit(0.5, 65536.0)),
    ],
)
def test_factors_are_units(text, unit):
    found = read_unit(text)
    assert found.factor == pytest.approx(unit.factor)
    assert found.word == unit.word


@pytest.mark.parametrize("text", ["", "x", "1/0", "0", "inf", "deg*", "1/i16", "i16*i16"])
def test_units_that_are_none_are_refused(text):
    with pytest.raises((ValueError, ZeroDivisionError)):
        read_unit(text)


def test_a_sign_that_was_lost_comes_back():
    assert Unit(1.0, 65536.0)(np.array([0.0, 1.0, 65535.0, 32767.0, 32768.0])).tolist() == [
        0, 1, -1, 32767, -32768,
    ]  # fmt: skip


def test_a_stored_run_is_checked_in_words_of_its_file(arm, capsys):
    assert _import(arm, "--name", "a", "--map", "stamp=time", *MAP[1:]) == 0
    capsys.readouterr()
    words = ["run", "check", "a", "--profile", str(arm / "arm.yaml")]
    main(["--data", str(arm / "data"), *words])
    out = capsys.readouterr().out
    assert "look like milliseconds → --map 'stamp[ms]=time'" in out
