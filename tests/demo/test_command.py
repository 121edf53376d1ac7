"""``pa10d demo`` as a user calls it: its processes, its document, its report."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from small_arm import small_arm

HEADS = ("hidden", "joint", "found", "rms_before", "rms_after", "report")


def started(*arguments, **more):
    command = [sys.executable, "-m", "pa10d", "demo", *arguments]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, text=True, **pipes, **more)


def marked(mark: str) -> list[str]:
    """Command lines of living processes that inherited this mark."""
    wanted, found = f"PA10D_TEST_DEMO={mark}".encode(), []
    for path in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if wanted in (path / "environ").read_bytes().split(b"\0"):
                found.append((path / "cmdline").read_bytes().replace(b"\0", b" ").decode())
    return found


@pytest.mark.long
@pytest.mark.parametrize(
    "blow", [signal.SIGINT, pytest.param(signal.SIGKILL, marks=pytest.mark.long)]
)
def test_no_process_stays_behind(tmp_path, blow):
    """After Ctrl-C, and even after its death, daemon and simulated arm end, too."""
    mark = f"{os.getpid()}-{blow}"
    environment = {**os.environ, "PA10D_TEST_DEMO": mark}
    arguments = ["--hide", "none", "--seed", "1", "--report", str(tmp_path / "report.html")]
    arguments += ["--profile", str(small_arm(tmp_path))]
    with started(*arguments, env=environment) as demo:
        for line in demo.stderr:
            if "moving" in line:
                break
        assert len(marked(mark)) >= 5, "demo, daemon, control, recorder, simulator"
        demo.send_signal(blow)
        demo.stderr.read()
        demo.wait(60)
    assert demo.returncode == (130 if blow == signal.SIGINT else -signal.SIGKILL)
    until = time.monotonic() + 40
    while marked(mark) and time.monotonic() < until:
        time.sleep(0.2)
    assert marked(mark) == []


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize("asked", ["stribeck:4", "load_friction:2", "payload", "none"])
def test_the_command_prints_one_document(asked, tmp_path):
    file = tmp_path / "report.html"
    demo = started("--hide", asked, "--seed", "1", "--report", str(file), "--json", cwd=tmp_path)
    out, words = demo.communicate()
    assert demo.returncode == 0, words
    answer = json.loads(out)
    name, _, joint = asked.partition(":")
    hidden = None if name == "none" else name
    assert set(HEADS) <= set(answer)
    assert (answer["hidden"], answer["found"]) == (hidden, hidden)
    assert answer["joint"] == (int(joint) if joint else None)
    assert answer["right"] is True
    assert answer["report"] == str(file)
    assert "The diagnosis was right" in file.read_text(encoding="utf-8")
    falls = [a / b for a, b in zip(answer["rms_after"], answer["rms_before"], strict=True)]
    assert min(falls) < 0.6 if hidden else set(falls) == {1.0}
