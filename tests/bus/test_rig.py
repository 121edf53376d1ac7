"""What needs SocketCAN and systemd, run where there is both: in the rig's own machine."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RIG = ROOT.parent / "shared" / "rig"


pytestmark = [
    pytest.mark.long,
    pytest.mark.timeout(1200),
    pytest.mark.skipif(not (RIG / "run.sh").exists(), reason="no rig beside the project"),
    pytest.mark.skipif(os.getuid() != 0, reason="the rig needs root"),
    pytest.mark.skipif(
        shutil.which("linux.uml") is None, reason="user-mode-linux is not installed: rig/build.sh"
    ),
]


def in_rig(half: str) -> str:
    """What the tests of this half printed; they passed."""
    command = [ROOT / "scripts" / "rig-tests", half, "--long"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1100)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-2000:]
    assert "skipped" not in done.stdout
    return done.stdout


def test_the_socketcan_tests_pass_in_the_rig() -> None:
    passed = re.search(r"(\d+) passed", in_rig("can"))
    assert passed
    assert int(passed[1]) >= 3


def test_the_service_is_started_watched_and_stopped_in_the_rig() -> None:
    said = in_rig("service")
    assert said.count("PASS ") >= 20
    assert "FAIL " not in said
