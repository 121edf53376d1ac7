"""Whatever a command writes to: no traceback, the right status, and JSON that is JSON."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

COMMAND = f"{sys.executable} -m pa10d --data ."


def typed(words, place, **environment):
    return subprocess.run(
        ["bash", "-c", words], cwd=place, capture_output=True, timeout=120, check=False,
        env={**os.environ, **environment},
    )  # fmt: skip


@pytest.mark.long
def test_a_terminal_without_our_letters(tmp_path):
    shown = typed(f"{COMMAND} effect list", tmp_path, PYTHONIOENCODING="ascii")
    assert (shown.returncode, shown.stderr) == (0, b"")
    written = typed(f"{COMMAND} --json effect list", tmp_path, PYTHONIOENCODING="ascii")
    assert written.returncode == 0
    found = json.loads(written.stdout.decode("ascii"))
    assert not found[0]["equation"].isascii(), "nothing was shown"


@pytest.mark.by_default(">&-")
@pytest.mark.parametrize("closed", [">&-", "<&- >&- 2>&-"])
def test_a_closed_stream_leads_nowhere(tmp_path, closed):
    found = typed(f"{COMMAND} profile list {closed}", tmp_path)
    assert (found.returncode, found.stderr) == (0, b"")


def test_a_full_disk_behind_the_answer_is_one_line(tmp_path):
    found = typed(f"{COMMAND} --json profile list > /dev/full", tmp_path)
    assert found.returncode == 1
    assert found.stderr == b"No space left on device\n"
