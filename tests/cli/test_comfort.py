"""What makes the command line easy: examples, suggestions, completion, a remembered profile."""

from __future__ import annotations

import json
import os
import pty
import shlex
import subprocess
import sys
import time

import pytest

from pa10d.cli import main, whole_parser
from pa10d.cli.progress import ProgressLine
from pa10d.cli.remembered import FILE

URDF = """<robot name="one"><link name="base"/>
<joint name="a" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l1"><inertial><mass value="3"/><origin xyz="0.04 0 0.2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


@pytest.mark.parametrize("leaf", list(whole_parser().leaves()), ids=lambda leaf: leaf.prog)
def test_every_command_has_examples_that_can_be_typed(leaf):
    assert leaf.examples
    for line in leaf.examples:
        words = shlex.split(line.split(" | ")[0].removeprefix('eval "$(').removesuffix(')"'))
        options = whole_parser().parse_args(words[1:])
        assert options.parser.prog == leaf.prog, line
    assert leaf.examples[0] in leaf.format_help()


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (["diagnos"], "diagnose"),
        (["run", "improt"], "import"),
        (["diagnose", "m", "--fit", "a", "--validte", "b"], "--validate"),
        (["model", "export", "m", "--format", "mjfc"], "mjcf"),
    ],
)
def test_a_misspelt_word_is_answered_with_the_likely_one(capsys, arguments, meant):
    with pytest.raises(SystemExit):
        main(arguments)
    assert f"did you mean {meant}?" in capsys.readouterr().err


def test_nothing_like_it_gives_no_guess(capsys):
    with pytest.raises(SystemExit):
        main(["xyzzy"])
    assert "did you mean" not in capsys.readouterr().err


@pytest.fixture
def robot(tmp_path):
    place = tmp_path / "robots"
    place.mkdir()
    (place / "one.urdf").write_text(URDF)
    rows = ["time,q1,tau1", *(f"{k / 100},{k % 7 / 10},{k % 5 / 10}" for k in range(300))]
    (tmp_path / "train.csv").write_text("\n".join(rows))
    return place / "one.urdf"


def _import(tmp_path, data, *more):
    return main(["--data", str(data), "run", "import", str(tmp_path / "train.csv"), *more])


def test_the_profile_last_used_with_the_data_stands_for_the_next(tmp_path, robot, capsys):
    data = tmp_path / "data"
    assert _import(tmp_path, data, "--profile", str(robot)) == 0
    assert json.loads((data / FILE).read_text())["profile"] == str(robot)
    assert _import(tmp_path, data, "--name", "again") == 0
    assert f"profile {robot}, as last used with this data" in capsys.readouterr().err
    assert _import(tmp_path, tmp_path / "other") == 1  # one joint is not seven


def test_a_profile_in_the_data_folder_itself_is_not_remembered_and_it_is_said(
    tmp_path, robot, capsys
):
    assert _import(tmp_path, robot.parent, "--profile", str(robot)) == 0
    assert "lies in the data folder: --profile is needed each time" in capsys.readouterr().err
    assert not (robot.parent / FILE).exists()


def test_a_data_folder_from_elsewhere_chooses_no_profile(tmp_path, robot, capsys):
    data = tmp_path / "data"
    assert _import(tmp_path, data, "--profile", str(robot)) == 0
    data.rename(tmp_path / "moved")
    assert _import(tmp_path, tmp_path / "moved") == 1
    inside = tmp_path / "moved" / "evil.urdf"
    inside.write_text(URDF)
    (tmp_path / "moved" / FILE).write_text(
        json.dumps({"profile": str(inside), "data": str(tmp_path / "moved")})
    )
    assert _import(tmp_path, tmp_path / "moved") == 1
    assert "as last used" not in capsys.readouterr().err


@pytest.mark.parametrize("damage", ["", "[]", "{}", '{"profile": 3, "data": "x"}', "\x00"])
def test_a_damaged_memory_is_none(tmp_path, robot, damage):
    data = tmp_path / "data"
    data.mkdir()
    (data / FILE).write_text(damage)
    assert main(["--data", str(data), "run", "check", "nothing"]) == 1
    assert _import(tmp_path, data, "--profile", str(robot)) == 0


def _completed(line: str, data) -> list[str]:
    """What the shell is given for the line."""
    environment = {
        **os.environ, "_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line)),
        "_ARGCOMPLETE_IFS": "\n", "_ARGCOMPLETE_SUPPRESS_SPACE": "1", "PA10D_DATA": str(data),
        "_ARGCOMPLETE_STDOUT_FILENAME": str(data / "said"),
    }  # fmt: skip
    command = [sys.executable, "-c", "import sys; from pa10d.cli import main; sys.exit(main())"]
    subprocess.run(command, env=environment, check=True, timeout=60)
    return (data / "said").read_text().split("\n")


@pytest.mark.long
def test_the_tab_key_knows_commands_options_and_names(tmp_path, robot):
    data = tmp_path / "data"
    assert _import(tmp_path, data, "--profile", str(robot), "--name", "monday") == 0
    assert _completed("pa10d diag", data) == ["diagnose"]
    assert "--validate" in _completed("pa10d diagnose --val", data)
    assert _completed("pa10d run show mon", data) == ["monday"]
    assert "pa10-7c" in _completed("pa10d serve --profile pa10-", data)
    assert _completed("pa10d add m strib", data) == ["stribeck"]
    assert "stribeck" in _completed("pa10d diagnose m --fit monday --effect strib", data)


def test_progress_in_lines_says_what_is_new_and_how_long_it_takes(capsys, monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    line = ProgressLine()
    for share in (0.0, 0.01, 0.02, 0.2, 0.25, 0.9):
        clock[0] = 100 * share
        line(share, "fitting")
    line(0.91, "judging")
    assert capsys.readouterr().err.splitlines() == [
        "  0%  fitting",
        " 20%  fitting (about 80 s left)",
        " 90%  fitting",
        " 91%  judging",
    ]


def test_what_begins_after_other_work_has_its_own_time(capsys, monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    line = ProgressLine()
    line(0.0, "finding what is missing")
    clock[0] = 400.0
    line(0.9, "judging")
    line(0.0, "asking what has changed")
    clock[0] = 420.0
    line(0.2, "moving")
    assert capsys.readouterr().err.splitlines()[-1] == " 20%  moving (about 80 s left)"


def test_progress_on_a_terminal_is_a_bar_that_leaves_no_trace():
    script = (
        "from pa10d.cli.progress import progress_line, end_progress; show = progress_line()\n"
        "show(0.3, 'fitting'); import time; time.sleep(0.3); end_progress(); print('end')"
    )
    leader, follower = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "80"}
    with subprocess.Popen([sys.executable, "-c", script], env=environment, stderr=follower):
        pass
    os.close(follower)
    said = b""
    try:
        while more := os.read(leader, 4096):
            said += more
    except OSError:
        pass
    assert b"fitting" in said
    assert b"30%" in said
    assert said.rfind(b"\x1b[?25h") > said.rfind(b"\x1b[?25l"), "the cursor is back"
