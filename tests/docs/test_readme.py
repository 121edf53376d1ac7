"""Every command of the README is run here, or it is said where."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import httpx
import pytest
from documents import ROOT, commands
from sprung_arm import URDF, recording

ELSEWHERE = {
    "scripts/test": "runs this test",
    "scripts/demo": "test_the_demo_script, with --long; tests/demo has the story",
    "sudo ip link set can0 up type can bitrate 1000000": "scripts/rig-tests, on a real interface",
}
ELSEWHERE_BY_DEFAULT = {
    "pa10d serve --hide any --clock simulated": "tests/daemon/test_night; here with --long",
    "pa10d serve --profile profiles/arm.yaml": "pa10d check, just before it; here with --long",
    "pa10d diagnose m0 --fit train --validate valid": "improve searches the same; with --long",
}


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    """A folder such as a user has: the shipped profiles, a URDF, two recordings."""
    folder = tmp_path_factory.mktemp("readme")
    shutil.copytree(ROOT / "profiles", folder / "profiles")
    (folder / "robot.urdf").write_text(URDF)
    recording(folder / "train.csv", 1)
    recording(folder / "valid.csv", 2)
    return folder


@pytest.fixture(scope="module")
def environment(place) -> dict[str, str]:
    bin_folder = str(Path(sys.executable).parent)
    path = f"{bin_folder}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "PA10D_DATA": str(place)}


def run(command: str, place: Path, environment: dict[str, str]) -> subprocess.CompletedProcess:
    return subprocess.run(
        command, shell=True, cwd=place, env=environment, capture_output=True, text=True, timeout=240
    )


def serve(command: str, place: Path, environment: dict[str, str]) -> dict:
    """The robot's state once it answers, with its page; a port and a bus of its own."""
    options = ["--port", "0", "--channel", f"readme-{os.getpid()}"]
    process = subprocess.Popen(
        [*command.split(), *options], cwd=place, env=environment, stderr=subprocess.PIPE, text=True
    )
    try:
        for line in process.stderr:
            if " serves " in line:
                break
        url = line.split()[-1]
        assert "pa10d" in httpx.get(f"{url}/", trust_env=False, timeout=60).text
        assert httpx.get(f"{url}/healthz", trust_env=False, timeout=60).json()["status"] == "ok"
        return httpx.get(f"{url}/api/v1/robot", trust_env=False, timeout=60).json()
    finally:
        process.terminate()
        process.wait(40)
        process.stderr.close()


def test_every_command_does_what_it_says(place, environment, pytestconfig):
    done = []
    elsewhere = {} if pytestconfig.getoption("--long") else ELSEWHERE_BY_DEFAULT
    for command in commands("README.md"):
        if command in ELSEWHERE or command in elsewhere:
            continue
        if command.startswith("pa10d serve"):
            robot = serve(command, place, environment)
            if "robot.yaml" in command:
                assert robot["offline_reason"] == "profile robot names no drives"
        elif command.startswith("pa10d check"):  # no such interface here: a clear no
            found = run(command, place, environment)
            assert found.returncode == 1, found.stderr
            assert "no go" in found.stdout
            assert "can0" in found.stdout
        else:
            found = run(command, place, environment)
            assert found.returncode == 0, f"{command}\n{found.stdout}\n{found.stderr}"
        done.append(command)
        if command.startswith("pa10d diagnose"):
            assert "pring" in found.stdout, found.stdout
    assert len(done) >= 9
    assert (place / "compare.html").stat().st_size > 1_000_000
    listed = run("pa10d model history m1", place, environment)
    assert "added spring J2" in listed.stdout


def test_what_is_run_elsewhere_is_in_the_readme():
    assert {*ELSEWHERE, *ELSEWHERE_BY_DEFAULT} <= set(commands("README.md"))


@pytest.mark.parametrize("script", ["scripts/demo", "scripts/test"])
def test_the_scripts_can_be_read_by_bash(script):
    path = ROOT / script
    assert os.access(path, os.X_OK)
    subprocess.run(["bash", "-n", str(path)], check=True)


@pytest.mark.long
@pytest.mark.timeout(900)
def test_the_demo_script(tmp_path):
    found = subprocess.run(
        [ROOT / "scripts/demo", "--hide", "stribeck:4", "--seed", "1"],
        cwd=tmp_path, capture_output=True, text=True, timeout=900,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    assert "Stribeck friction in joint 4" in found.stdout + found.stderr


def test_links_and_pictures_are_there():
    import re

    text = (ROOT / "README.md").read_text()
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        assert (ROOT / target).exists(), target
