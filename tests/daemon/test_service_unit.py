"""The unit that ``scripts/install-service`` writes; it runs under a real systemd in the rig."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def unit(*options, profile="pa10-7c"):
    command = [sys.executable, ROOT / "scripts" / "install-service", "--print"]
    return subprocess.run(
        [*command, "--profile", profile, *map(str, options)], capture_output=True, text=True
    )


def settings(done):
    """KEY → values, of all sections."""
    assert done.returncode == 0, done.stderr
    found = {}
    for line in done.stdout.splitlines():
        key, equals, value = line.partition("=")
        if equals and not line.startswith("#"):
            found.setdefault(key, []).append(value)
    assert not re.search("@[A-Z_]+@", done.stdout), "a blank was not filled in"
    return found


def test_bound_to_the_interface_of_the_profile():
    found = settings(unit())
    device = "sys-subsystem-net-devices-can0.device"
    assert found["BindsTo"] == [device]
    assert device in found["WantedBy"][0]
    assert found["Type"] == ["notify"]
    assert float(found["WatchdogSec"][0]) > 5.0, "control must have brought the arm to rest first"
    assert found["IPAddressDeny"] == ["any"]
    assert found["PrivateDevices"] == ["yes"]


def test_a_bus_without_an_interface_binds_to_nothing():
    found = settings(unit(profile="pa10-sim"))
    assert "BindsTo" not in found
    assert found["WantedBy"] == ["multi-user.target"]


def test_data_of_a_user_may_be_written(tmp_path):
    found = settings(unit("--user", "somebody", "--data", tmp_path))
    assert found["User"] == ["somebody"]
    assert set(found["ReadWritePaths"]) == {str(tmp_path), "-/run/lock"}
    assert f"--data {tmp_path} " in found["ExecStart"][0]


def test_wrong_requests_are_one_line(tmp_path):
    for options, said in (
        (["--data", tmp_path / "nowhere"], "expected an existing folder"),
        (["--host", "0.0.0.0"], "--token-file is needed"),
    ):
        done = unit(*options)
        assert done.returncode != 0
        assert said in done.stderr.splitlines()[-1]
    done = unit(profile="nobody")
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1


def test_memory_that_runs_out_takes_a_worker_never_control():
    found = settings(unit())
    assert found["OOMPolicy"] == ["continue"]
    assert int(found["OOMScoreAdjust"][0]) < 0
    assert found["MemoryMax"] == ["80%"]
