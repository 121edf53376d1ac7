"""Every command of the README is run here, or it is said where."""

from __future__ import annotations

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import httpx
import numpy as np
import pytest
from documents import ROOT, commands

from pa10d.dynamics import inverse_dynamics, robot_from_urdf

URDF = """<robot name="two"><link name="base"/>
<joint name="a" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l1"><inertial><mass value="3"/><origin xyz="0.04 0 0.2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="b" type="revolute"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/>
<origin xyz="0 0 0.4"/><limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l2"><inertial><mass value="2"/><origin xyz="0.02 0 0.15"/>
<inertia ixx="0.03" iyy="0.03" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
STIFF = 6.0  # N·m/rad: a spring at the second joint that no textbook model has
RATE, SECONDS, NOISE = 200.0, 20.0, 0.05

ELSEWHERE = {
    "scripts/test": "runs this test",
    "scripts/demo": "test_the_demo_script, with --long; tests/demo has the story",
    "sudo ip link set can0 up type can bitrate 1000000": "scripts/rig-tests, on a real interface",
}


def recording(path: Path, seed: int) -> None:
    """Two joints, a spring on one of them, noise."""
    rng = np.random.default_rng(seed)
    robot = robot_from_urdf(URDF)
    t = np.arange(round(SECONDS * RATE)) / RATE
    w = 2 * np.pi * rng.uniform(0.08, 0.9, (6, 2))
    a, phase = rng.uniform(0.1, 0.3, (6, 2)), rng.uniform(0, 2 * np.pi, (6, 2))
    angle = w[None] * t[:, None, None] + phase
    q = (a * np.sin(angle)).sum(axis=1)
    dq = (a * w * np.cos(angle)).sum(axis=1)
    ddq = -(a * w**2 * np.sin(angle)).sum(axis=1)
    tau = inverse_dynamics(robot, robot.parameters, q, dq, ddq) + 0.3 * ddq
    tau += 1.5 * np.tanh(dq / 0.01) + 2.0 * dq + rng.normal(0, NOISE, q.shape)
    tau[:, 1] += STIFF * q[:, 1]
    with path.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["time", "q1", "q2", "tau1", "tau2"])
        out.writerows(np.column_stack([t, q, tau]).tolist())


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


def test_every_command_does_what_it_says(place, environment):
    done = []
    for command in commands("README.md"):
        if command in ELSEWHERE:
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
    assert len(done) >= 10
    assert (place / "compare.html").stat().st_size > 1_000_000
    listed = run("pa10d model history m1", place, environment)
    assert "added spring J2" in listed.stdout


def test_what_is_run_elsewhere_is_in_the_readme():
    assert set(ELSEWHERE) <= set(commands("README.md"))


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
