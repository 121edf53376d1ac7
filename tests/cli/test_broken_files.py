"""Broken files given to the command line: status 1, one clear line, nothing lost.

In every case an existing run of the same name was to be replaced; it must still be there, bit for
bit, after the refusal.
"""

from __future__ import annotations

import gzip
import json

import numpy as np
import pytest
from test_run_commands import URDF

from pa10d.cli import main
from pa10d.store import RunStore
from pa10d.store.models import ModelStore

T = np.arange(300) / 200
TABLE = np.stack([T, np.sin(T), np.cos(2 * T), T, -T], axis=1)
HEAD = "time,q1,q2,tau1,tau2"
ROWS = [",".join(f"{value:.6f}" for value in row) for row in TABLE]
GOOD = "\n".join([HEAD, *ROWS]) + "\n"


def _cell(line, column, text):
    cells = ROWS[line - 2].split(",")
    cells[column - 1] = text
    return "\n".join([HEAD, *ROWS[: line - 2], ",".join(cells), *ROWS[line - 1 :]]) + "\n"


CSV = {
    "empty": (b"", "rec.csv: an empty file"),
    "header alone": (HEAD.encode(), "rec.csv: found 0 samples, expected at least 100"),
    "no header": ("\n".join(ROWS).encode(), "rec.csv:1: found numbers, expected a header"),
    "missing column": (GOOD.replace("tau2", "x", 1).encode(), "rec.csv:1: no column tau2"),
    "column twice": (GOOD.replace("q2", "q1", 1).encode(), "columns 2 and 3 are both 'q1'"),
    "semicolons": (
        _cell(7, 4, "n/a").replace(",", ";").encode(),
        "rec.csv:7: column 4 (tau1): found 'n/a', expected",
    ),
    "text": (_cell(7, 4, "n/a").encode(), "rec.csv:7: column 4 (tau1): found 'n/a', expected"),
    "hole": (_cell(88, 2, "").encode(), "rec.csv:88: column 2 (q1): found an empty cell"),
    "not a number": (_cell(9, 5, "NaN").encode(), "rec.csv:9: column 5 (tau2): found 'NaN'"),
    "infinite": (_cell(9, 5, "1e999").encode(), "rec.csv:9: column 5 (tau2): found '1e999'"),
    "decimal commas": (_cell(4, 2, "0,5").encode(), "rec.csv:4: found 6 columns, expected 5"),
    "cut off": (GOOD[:-25].encode(), "was the file cut off?"),
    "backwards": (_cell(60, 1, "0.1").encode(), "rec.csv:60: column time: found 0.1 after"),
    "all one time": (
        "\n".join([HEAD, *(f"0{r[r.index(','):]}" for r in ROWS)]).encode(),
        "rec.csv: found 1 different stamps, expected at least 100",
    ),
    "no text": (GOOD.encode().replace(b"0.5", b"0\xb75", 1), "is not UTF-8; expected a text file"),
    "two bytes a letter": (
        _cell(7, 4, "n/a").encode("utf-16"),
        "rec.csv:7: column 4 (tau1): found 'n/a', expected",
    ),
    "packed and cut": (gzip.compress(GOOD.encode())[:-500], "expected a whole .gz file"),
    "binary": (bytes(range(256)) * 20, "rec.csv:"),
}  # fmt: skip

YAML = {
    "empty": ("", "arm.yaml:1: found an empty file"),
    "not YAML": ("urdf: [two.urdf\n", "arm.yaml:2: "),
    "no urdf": ("name: arm\n", "arm.yaml:1: urdf: found nothing, expected the path of a URDF file"),
    "urdf is not there": ("urdf: three.urdf\n", "arm.yaml:1: urdf: found 'three.urdf', expected"),
    "unknown key": ("urdf: two.urdf\njoint: [a]\n", "arm.yaml:2: joint: found an unknown key"),
    "unknown joint": ("urdf: two.urdf\njoints: [a, z]\n", "joint 'z' is not a movable joint"),
    "wrong length": (
        "urdf: two.urdf\nlimits: {velocity: [1]}\n",
        "found 1 values, expected 2",
    ),
    "constants of wrong length": (
        "urdf: two.urdf\ntorque_constants: [1, 2, 3]\n",
        "torque_constants: found 3 entries, expected 2, one for each joint of arm (a, b)",
    ),
    "wrong kind": ("urdf: two.urdf\ncontrol: {rate: fast}\n", "control.rate: found 'fast'"),
    "key twice": ("urdf: two.urdf\nurdf: x\n", "arm.yaml:2: urdf: found a second time"),
}

URDFS = {
    "empty": ("", "not well-formed XML"),
    "cut off": (URDF[:400], "not well-formed XML"),
    "something else": ("<html></html>", "found <html>, expected <robot>"),
    "nothing moves": ('<robot name="x"><link name="a"/></robot>', "no movable joint"),
    "no links": ('<robot name="x"/>', "found no <link>"),
    "unknown link": (
        URDF.replace('<child link="l2"/>', '<child link="l3"/>'),
        "joint 'b': found child link 'l3', expected one of the file",
    ),
    "joint twice": (URDF.replace('name="b"', 'name="a"'), "joint 'a': found 2 times"),
    "two bases": (
        URDF.replace('<link name="base"/>', '<link name="base"/><link name="c"/>'),
        "found 2 links without a parent (base, c), expected one base",
    ),
    "closed chain": (
        URDF.replace('<parent link="base"/>', '<parent link="l2"/>'),
        "found in a closed chain, expected a tree",
    ),
    "two parents": (
        URDF.replace('<child link="l2"/>', '<child link="l1"/>'),
        "link 'l1': found as the child of two joints",
    ),
    "no number": (
        URDF.replace('<mass value="1"/>', '<mass value="heavy"/>'),
        "link 'l2': found <mass value='heavy'>, expected a number",
    ),
    "unfinished xacro": (
        URDF.replace('upper="3"', 'upper="${pi}"'),
        "joint 'b': found <limit upper='${pi}'>, expected a number",
    ),
    "negative mass": (URDF.replace('value="2"', 'value="-2"'), "link 'l1': found mass -2"),
    "no inertia": (
        URDF.replace('<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>', "", 1),
        "link 'l1': found <inertial> without <inertia>",
    ),
    "half an axis": (
        URDF.replace('xyz="0 1 0"', 'xyz="0 1"'),
        "joint 'b': found <axis xyz='0 1'>, expected three numbers",
    ),
    "no axis": (URDF.replace('xyz="0 1 0"', 'xyz="0 0 0"'), "joint 'b': found axis 0 0 0"),
    "no limit": (
        URDF.replace('<limit lower="-3" upper="3" effort="100" velocity="9"/>', ""),
        "joint 'b': found no <limit>",
    ),
    "limits the wrong way": (
        URDF.replace('lower="-3" upper="3"', 'lower="3" upper="-3"'),
        "joint 'b': found limits 3 … -3, expected the lower one first",
    ),
    "unknown type": (
        URDF.replace('name="b" type="revolute"', 'name="b" type="hinge"'),
        "joint 'b': found type 'hinge', expected one of revolute",
    ),
}


@pytest.fixture
def place(tmp_path, monkeypatch, capfd):
    """Good files, and a run 'keep' that every broken one tries to replace."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PA10D_DATA", str(tmp_path / "data"))
    (tmp_path / "two.urdf").write_text(URDF)
    (tmp_path / "arm.yaml").write_text("urdf: two.urdf\n")
    (tmp_path / "rec.csv").write_text(GOOD)
    assert _import() == 0
    capfd.readouterr()
    return tmp_path


def _import(*more):
    return main(["run", "import", "rec.csv", "--profile", "arm.yaml", "--name", "keep", *more])


def _everything(place):
    return {p: p.read_bytes() for p in sorted((place / "data").rglob("*")) if p.is_file()}


def _refused(place, capfd, said):
    """Also what libraries print below Python is seen: capfd watches the file descriptors."""
    before = _everything(place)
    assert _import("--replace", "--json") == 1
    out, err = capfd.readouterr()
    assert err.count("\n") == 1
    assert said in err
    assert "Traceback" not in err
    assert json.loads(out) == {"error": err.strip()}
    assert _everything(place) == before
    assert RunStore().recording("keep").q.shape == (300, 2)


@pytest.mark.parametrize("case", CSV)
def test_a_broken_csv(place, capfd, case):
    data, said = CSV[case]
    (place / "rec.csv").write_bytes(data)
    _refused(place, capfd, said)


@pytest.mark.parametrize("case", YAML)
def test_a_broken_profile(place, capfd, case):
    text, said = YAML[case]
    (place / "arm.yaml").write_text(text)
    _refused(place, capfd, said)


@pytest.mark.parametrize("case", URDFS)
def test_a_broken_urdf(place, capfd, case):
    text, said = URDFS[case]
    (place / "two.urdf").write_text(text)
    _refused(place, capfd, said)


@pytest.mark.parametrize("missing", ["rec.csv", "arm.yaml", "two.urdf"])
def test_a_file_that_is_not_there(place, capfd, missing):
    (place / missing).unlink()
    _refused(place, capfd, missing)


@pytest.mark.parametrize(
    ("what", "name"), [("run", "runs/stray.csv"), ("model", "models/bad.yaml")]
)
def test_a_list_says_what_was_set_aside(place, capfd, what, name):
    RunStore(), ModelStore()
    bad = place / "data" / name
    bad.write_text("- 1")
    assert main([what, "list"]) == 0
    out, err = capfd.readouterr()
    assert f"warning: set aside: {bad}" in err
    assert str(bad) not in out
