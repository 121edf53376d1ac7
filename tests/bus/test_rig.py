"""The SocketCAN tests, run where there is SocketCAN: in the rig's own machine."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RIG = ROOT.parent / "shared" / "rig"


@pytest.mark.long
@pytest.mark.skipif(not (RIG / "run.sh").exists(), reason="no rig beside the project")
@pytest.mark.skipif(os.getuid() != 0, reason="the rig needs root")
@pytest.mark.skipif(
    shutil.which("linux.uml") is None, reason="user-mode-linux is not installed: rig/build.sh"
)
def test_the_socketcan_tests_pass_in_the_rig() -> None:
    done = subprocess.run(
        [ROOT / "scripts" / "rig-tests"], capture_output=True, text=True, timeout=280
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-2000:]
    passed = re.search(r"(\d+) passed", done.stdout)
    assert passed, done.stdout
    assert int(passed[1]) >= 3
    assert "skipped" not in done.stdout
