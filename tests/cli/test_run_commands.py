"""``pa10d run …`` from a file to its exports, as a user types it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from pa10d.cli import main
from pa10d.store import RunStore

URDF = """<robot name="two"><link name="base"/>
<joint name="a" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/>
<limit lower="-0.9" upper="0.9" effort="100" velocity="9"/></joint>
<link name="l1"><inertial><mass value="2"/><origin xyz="0.1 0 0"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="b" type="revolute"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l2"><inertial><mass value="1"/><origin xyz="0.1 0 0"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a profile and a recording, and a data folder."""
    monkeypatch.setenv("PA10D_DATA", str(tmp_path / "data"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two.urdf").write_text(URDF)
    (tmp_path / "two.yaml").write_text("urdf: two.urdf\n")
    t = np.arange(4000) / 200
    rng = np.random.default_rng(0)
    columns = [t, np.sin(t), np.cos(2 * t), *(rng.normal(size=(2, 4000)))]
    _write(tmp_path / "rec.csv", "time,q1,q2,tau1,tau2", columns)
    return tmp_path


def _write(path, header, columns):
    np.savetxt(path, np.stack(columns, axis=1), delimiter=",", header=header, comments="")


def _json(capsys, *arguments):
    assert main([*arguments, "--json"]) == 0
    said = capsys.readouterr()
    return json.loads(said.out), said.err


def test_import_show_list_export_delete(place, capsys):
    assert main(["run", "import", "rec.csv", "--profile", "two.yaml"]) == 0
    said = capsys.readouterr()
    run_id = said.out.strip()
    assert "joint 1 (a): q reaches -1 rad, limits -0.9 … 0.9" in said.err
    shown, _ = _json(capsys, "run", "show", "rec")
    assert shown["id"] == run_id
    assert shown["joints"] == ["a", "b"]
    assert (shown["samples"], shown["rate"], shown["status"]) == (4000, 200.0, "success")
    assert shown["per_joint"][0]["q_max"] == pytest.approx(1.0, abs=1e-3)
    assert shown["profile"] == "two"
    listed, _ = _json(capsys, "run", "list")
    assert [run["name"] for run in listed] == ["rec"]
    answer, _ = _json(capsys, "run", "export", run_id[:21], "--format", "mat")
    assert answer["file"] == str(place / "rec.mat")
    assert (place / "rec.mat").stat().st_size > 0
    assert main(["run", "delete", "rec"]) == 0
    assert "deleted rec" in capsys.readouterr().out
    assert _json(capsys, "run", "list")[0] == []


def test_what_the_checks_said_is_shown_in_lines(place, capsys):
    main(["run", "import", "rec.csv", "--profile", "two.yaml", "--check"])
    info = RunStore().find("rec")
    assert info.findings
    store = RunStore()
    info.but(excluded=((0.5, 0.75),), unit_given=(0, 1)).save(store.path(info))
    capsys.readouterr()
    assert main(["run", "show", "rec"]) == 0
    shown = capsys.readouterr().out
    first = info.findings[0]
    assert f"findings: \n  {first['severity']}: {first['sentence']}" in shown
    assert "excluded: 0.5 to 0.75 s\n" in shown
    assert "unit_given: joints 1 and 2\n" in shown


def test_export_refuses_to_overwrite_the_source(place, capsys):
    main(["run", "import", "rec.csv", "--profile", "two.yaml"])
    before = (place / "rec.csv").read_bytes()
    capsys.readouterr()
    assert main(["run", "export", "rec", "--format", "csv"]) == 1
    assert "rec.csv: exists already" in capsys.readouterr().err
    assert (place / "rec.csv").read_bytes() == before


@pytest.mark.parametrize("form", ["csv", "mcap", "parquet", "mat"])
def test_exports_go_where_they_are_told(place, capsys, form):
    main(["run", "import", "rec.csv", "--profile", "two.yaml"])
    capsys.readouterr()
    answer, _ = _json(capsys, "run", "export", "rec", "--format", form, "--out", f"out.{form}")
    assert answer["file"] == str(place / f"out.{form}")
    assert (place / f"out.{form}").stat().st_size > 1000


def test_the_stored_folder_is_a_ros_2_bag(place, capsys):
    main(["run", "import", "rec.csv", "--profile", "two.yaml"])
    run_id = capsys.readouterr().out.strip()
    with Reader(place / "data" / "runs" / run_id) as reader:
        assert reader.message_count == 4000
        assert {c.topic for c in reader.connections} == {"/joint_states"}


def test_names_and_replace(place, capsys):
    first, _ = _json(capsys, "run", "import", "rec.csv", "--profile", "two.yaml", "--name", "n")
    assert main(["run", "import", "rec.csv", "--profile", "two.yaml", "--name", "n"]) == 1
    assert "run 'n': there is one already" in capsys.readouterr().err
    again, _ = _json(capsys, "run", "import", "rec.csv", "--profile", "two.yaml", "--name", "n",
                     "--replace")  # fmt: skip
    assert again["id"] != first["id"]
    assert [run["id"] for run in _json(capsys, "run", "list")[0]] == [again["id"]]


def test_check_tells_what_to_know(place, capsys):
    answer, said = _json(capsys, "run", "import", "rec.csv", "--profile", "two.yaml", "--check")
    assert {"rate", "limits"} <= {finding["code"] for finding in answer["findings"]}
    assert all(finding["sentence"] in said for finding in answer["findings"])
    stored, _ = _json(capsys, "run", "check", "rec", "--profile", "two.yaml")
    assert stored["findings"] == answer["findings"]
    assert main(["run", "check", "rec", "--profile", "pa10-sim"]) == 1
    assert "found 2 joints, expected the 7 of pa10-sim" in capsys.readouterr().err


def test_map_takes_several_at_once_and_again(place, capsys):
    columns = np.loadtxt(place / "rec.csv", delimiter=",", skiprows=1).T
    _write(place / "odd.csv", "stamp,p1,p2,e1,e2", columns)
    answer, _ = _json(
        capsys, "run", "import", "odd.csv", "--profile", "two.yaml",
        "--map", "stamp=time", "p1=q1", "p2=q2", "--map", "e1=tau1", "e2=tau2",
    )  # fmt: skip
    recording = RunStore().recording(answer["id"])
    np.testing.assert_array_equal(recording.q[:, 1], columns[2])


def test_repair_finishes_what_a_killed_recorder_left(place, capsys):
    from pa10d.store import Channels, Samples

    writer = RunStore().start("live", Channels(("a", "b")))
    block = np.zeros((50, 2))
    writer.append(Samples(np.arange(50) * 2_000_000, block, block))
    writer.flush()
    writer.abandon()
    repaired, _ = _json(capsys, "run", "repair")
    assert [(run["name"], run["repaired"], run["samples"]) for run in repaired] == [
        ("live", True, 50)
    ]
    assert main(["run", "repair"]) == 0
    assert "nothing to repair" in capsys.readouterr().out


def test_a_urdf_will_do_for_a_profile(place, capsys):
    answer, _ = _json(capsys, "run", "import", "rec.csv", "--profile", "two.urdf")
    assert answer["profile"] == "two"
