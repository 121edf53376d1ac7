"""The fixed points of the command line: options anywhere, exit statuses, JSON alone on stdout."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pa10d.cli import families, main
from pa10d.cli.answer import Answer, plain, print_answer
from pa10d.common.errors import UserError
from pa10d.store import RunStore

COMMAND = [sys.executable, "-c", "import sys; from pa10d.cli import main; sys.exit(main())"]


def _fails(capsys, arguments):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert capsys.readouterr().out == ""
    return stop.value.code


@pytest.mark.parametrize(
    "arguments",
    [
        ["--data", "{d}", "run", "list", "--json"],
        ["--json", "run", "list", "--data", "{d}"],
        ["run", "--data", "{d}", "--json", "list"],
        ["run", "--json", "list", "--data={d}"],
        ["--json", "--data", "{d}", "run", "list"],
    ],
)
def test_data_and_json_are_taken_before_and_after_the_command(tmp_path, capsys, arguments):
    data = str(tmp_path / "here")
    assert main([a.format(d=data) for a in arguments]) == 0
    assert json.loads(capsys.readouterr().out) == []
    assert (tmp_path / "here" / "runs").is_dir()


def test_the_last_data_folder_counts_and_the_environment_comes_after(tmp_path, monkeypatch):
    monkeypatch.setenv("PA10D_DATA", str(tmp_path / "environment"))
    assert main(["run", "list"]) == 0
    assert (tmp_path / "environment" / "runs").is_dir()
    assert main(["--data", str(tmp_path / "a"), "run", "list", "--data", str(tmp_path / "b")]) == 0
    assert not (tmp_path / "a").exists()
    assert (tmp_path / "b" / "runs").is_dir()


@pytest.mark.parametrize(
    "arguments",
    [[], ["run"], ["fly"], ["run", "list", "--jsn"], ["run", "export", "x"], ["run", "show"],
     ["run", "export", "x", "--format", "xls"], ["run", "list", "--js"], ["--data"]],
)  # fmt: skip
def test_wrong_usage_is_status_2(capsys, arguments):
    assert _fails(capsys, arguments) == 2


MISUSED = {
    "experiment": "experiment: expected either KIND or --plan FILE",
    "experiment tracking --plan nope.yaml": "experiment: expected either KIND or --plan FILE",
    "experiment tracking --set foo": "--set foo: expected KEY=VALUE",
    "weigh begin": "--weight: found none, expected MASS,X,Y,Z",
    "weigh guide": "--weight: found none, expected MASS,X,Y,Z",
    "track": "track: expected MODELs of this data, or --hide",
    "investigate --validate valid": "--validate: given without --fit",
    "diagnose m0 --fit train --joint 1": "--joint: given without --effect",
    "run import train.csv --map foo": "--map foo: expected COLUMN=FIELD",
    "profile tune foo": "foo: expected KEY=VALUE",
}


@pytest.mark.parametrize("words", MISUSED)
def test_words_that_cannot_be_meant_are_status_2_and_one_line(tmp_path, capsys, words):
    assert main([*words.split(), "--data", str(tmp_path)]) == 2
    said = capsys.readouterr()
    assert said.err.startswith(MISUSED[words])
    assert said.err.count("\n") == 1
    assert main([*words.split(), "--data", str(tmp_path), "--json"]) == 2
    assert MISUSED[words] in json.loads(capsys.readouterr().out)["error"]


@pytest.mark.parametrize("minutes", ["-1", "0", "nan", "soon"])
def test_no_minutes_are_status_2(capsys, minutes):
    assert _fails(capsys, ["investigate", "--minutes", minutes]) == 2


def test_a_value_may_begin_with_a_minus(tmp_path, capsys):
    assert main(["weigh", "begin", "--weight", "-1,0,0,0", "--data", str(tmp_path)]) == 2
    assert "-1,0,0,0" in capsys.readouterr().err


def test_the_default_robot_is_named_where_it_is_not_the_one(tmp_path, capsys):
    recording = tmp_path / "one.csv"
    recording.write_text("time,q1,tau1\n" + "".join(f"{k / 100},0,0\n" for k in range(50)))
    words = ["run", "import", str(recording), "--data", str(tmp_path / "data")]
    assert main(words) == 1
    assert "(pa10-sim is the default; --profile names another)" in capsys.readouterr().err
    assert main([*words, "--profile", "pa10-sim"]) == 1
    assert "is the default" not in capsys.readouterr().err


def test_a_profile_without_versions_says_so(tmp_path, capsys):
    words = ["profile", "versions", "--data", str(tmp_path)]
    assert main(words) == 0
    assert capsys.readouterr().out.startswith("none: ")
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == []


def test_a_urdf_that_is_not_there_is_said_so(tmp_path, capsys):
    assert main(["profile", "new", str(tmp_path / "nope.urdf")]) == 1
    assert "nope.urdf: no such file; expected a URDF" in capsys.readouterr().err


def test_what_could_not_be_done_is_status_1_and_one_line(tmp_path, capsys):
    assert main(["--data", str(tmp_path), "run", "show", "nothing"]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert said.err.startswith("run 'nothing': none of this name or id")


def test_with_json_a_failure_is_a_document_too(tmp_path, capsys):
    assert main(["--data", str(tmp_path), "run", "show", "nothing", "--json"]) == 1
    said = capsys.readouterr()
    assert json.loads(said.out) == {"error": said.err.strip()}


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (UserError("file:3: found x, expected y"), 1, "file:3: found x, expected y\n"),
        (PermissionError(13, "Permission denied", "/a/b"), 1, "/a/b: Permission denied\n"),
        (KeyboardInterrupt(), 130, "interrupted\n"),
    ],
)
def test_errors_become_one_line(tmp_path, capsys, monkeypatch, error, status, said):
    def fail(*_):
        raise error

    monkeypatch.setattr(RunStore, "all", fail)
    assert main(["--data", str(tmp_path), "run", "list"]) == status
    assert capsys.readouterr().err == said


def test_a_bug_of_ours_is_not_hidden(tmp_path, monkeypatch):
    monkeypatch.setattr("pa10d.cli.runs._extent", lambda info: 1 / 0)
    store = RunStore(tmp_path)
    from pa10d.store import Channels

    store.start("x", Channels(("a",))).close()
    with pytest.raises(ZeroDivisionError):
        main(["--data", str(tmp_path), "run", "list"])


def test_help_names_every_command_and_is_quick():
    """Beside what Python itself takes on this machine."""
    bare = [
        sys.executable,
        "-c",
        "import argparse, dataclasses, json, pathlib; print('run --data')",
    ]
    both = [(_timed([*COMMAND, "--help"]), _timed(bare)) for _ in range(3)]
    helped, python = (min(took) for took in zip(*both, strict=True))
    assert helped < 8.0 * max(python, 0.02)


def _timed(command):
    """s of processor time, whoever else uses this machine."""
    begin = os.times()
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    end = os.times()
    took = end.children_user + end.children_system - begin.children_user - begin.children_system
    assert "run " in done.stdout
    assert "--data" in done.stdout
    return took


def test_no_family_imports_anything_heavy():
    heavy = {"numpy", "scipy", "pinocchio", "numba", "pyarrow", "pydantic", "fastapi"}
    code = "import sys, pa10d.cli as c; c.families(); print(sorted(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not heavy & {name.strip("' []\n") for name in done.stdout.split(",")}


def test_every_family_declares_commands():
    assert "pa10d.cli.runs" in {family.__name__ for family in families()}
    assert all(callable(family.add_commands) for family in families())


def test_a_reader_that_goes_away_is_no_traceback(tmp_path):
    environment = os.environ | {"PA10D_DATA": str(tmp_path)}
    with subprocess.Popen(
        [*COMMAND, "run", "list"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment
    ) as process:
        process.stdout.close()
        assert process.stderr.read() == b""


def test_documents_are_strict_json(capsys):
    document = {
        "array": np.array([[1.5, np.nan]]),
        "number": np.float64(2.0),
        "count": np.int64(3),
        "infinite": float("inf"),
        "path": Path("/a"),
        "tuple": (True, None, "ä"),
    }
    print_answer(Answer(document, "not this"), as_json=True)
    assert json.loads(capsys.readouterr().out) == {
        "array": [[1.5, None]], "number": 2.0, "count": 3, "infinite": None, "path": "/a",
        "tuple": [True, None, "ä"],
    }  # fmt: skip
    assert plain(np.array(4.0)) == 4.0


def test_a_machine_without_memory_is_told_in_a_line(tmp_path, monkeypatch, capsys):
    def none_left(path):
        raise MemoryError

    monkeypatch.setattr("pa10d.profile.load.read_yaml", none_left)
    assert main(["--data", str(tmp_path), "profile", "show", "--profile", "pa10-sim"]) == 1
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1
    assert "no more memory" in said[0]


@pytest.mark.parametrize(
    "arguments", [["run", "import", "b\udcffd.csv"], ["run", "list", "--data=\udcff"]]
)
def test_a_name_that_is_no_text_is_wrong_usage(capsys, arguments):
    """Of files of old systems; what is written of them in JSON and YAML would be none."""
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert (
        capsys.readouterr()
        .err.splitlines()[-1]
        .endswith("expected text in UTF-8: give the file another name")
    )
