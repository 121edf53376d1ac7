"""The clients of docs/http-guide.md, as they stand there, against a daemon of our own."""

from __future__ import annotations

import json
import os
import shutil
import subprocess

import pyarrow as pa
import pytest
from documents import blocks, commands
from small_arm import small_arm

from pa10d.client import local_daemon

GUIDE = "docs/http-guide.md"
ADDRESS = "http://127.0.0.1:8010"


@pytest.fixture(scope="module")
def arm(tmp_path_factory, pytestconfig):
    """The text's arm has seven joints; most of it says nothing of them."""
    folder = tmp_path_factory.mktemp("guide")
    profile = "pa10-sim" if pytestconfig.getoption("--long") else str(small_arm(folder))
    with local_daemon(folder / "data", profile, clock="simulated") as client:
        yield client


def test_the_guide_is_as_expected():
    shell = commands(GUIDE)
    assert shell[0].startswith("pa10d --data bench serve --port 8010")
    assert ADDRESS in shell[1]
    assert len(blocks(GUIDE, "python")) == 2


def test_curl(arm, tmp_path):
    if shutil.which("curl") is None:
        pytest.skip("no curl here")
    (script,) = [code for code in blocks(GUIDE, "sh") if "curl" in code]
    made = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", script.replace(ADDRESS, arm.url)],
        cwd=tmp_path, env={**os.environ, "no_proxy": "127.0.0.1"},
        capture_output=True, text=True, timeout=240,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    assert (tmp_path / "first.csv").read_text().startswith("time,")
    columns = pa.ipc.open_stream((tmp_path / "first.arrow").read_bytes()).read_all()
    assert columns.column_names == ["time", "q1", "tau1"]
    runs = {run["name"]: run for run in arm.runs()}
    assert runs["first"]["tags"] == ["fit"]
    assert runs["again"]["samples"] == runs["first"]["samples"]
    assert json.loads(made.stdout.rpartition("}{")[2].join(["{", ""]))["state"] == "inactive"


# the first moves seven joints through two motions and fits a model; tests/api calls the client, too
@pytest.mark.parametrize("number", [pytest.param(0, marks=pytest.mark.long), 1])
def test_python(arm, capsys, number):
    arm._http.delete("/api/v1/robot/lease", headers={"X-Client": "me"})
    code = blocks(GUIDE, "python")[number].replace(ADDRESS, arm.url)
    exec(compile(code, GUIDE, "exec"), {})
    said = capsys.readouterr().out
    assert "worst joint:" in said if number == 0 else "time" in said
