"""Ctrl-C ends a command whatever it is in the middle of: status 130, no process left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from pa10d.store import RunStore

STUCK = """
import multiprocessing, sys, time
import pa10d.cli.process as process

def main():
    child = multiprocessing.get_context("fork").Process(target=time.sleep, args=(60,))
    child.start()
    print(child.pid, flush=True)
    while True:  # as deep in a library, where nobody notices
        try:
            time.sleep(60)
        except KeyboardInterrupt:
            pass

process.main = main
process.run()
"""
SOON = 5.0  # s: what is asked for is one, which a busy machine may stretch


def test_a_command_that_does_not_notice_is_ended_with_its_children():
    with subprocess.Popen([sys.executable, "-c", STUCK], stdout=subprocess.PIPE) as process:
        child = int(process.stdout.readline())
        process.send_signal(signal.SIGINT)
        assert process.wait(SOON) == 130
    with pytest.raises(ProcessLookupError):
        _wait_for_end(child)


@pytest.mark.parametrize("after", [0.5, 1.5])
def test_an_interrupted_import_leaves_nothing_half_written(tmp_path, after):
    rows = "\n".join(f"{k / 500}," + ",".join(["0.1"] * 14) for k in range(200_000))
    names = ",".join([f"q{j}" for j in range(1, 8)] + [f"tau{j}" for j in range(1, 8)])
    (tmp_path / "long.csv").write_text(f"time,{names}\n{rows}\n")
    process = subprocess.Popen(
        [sys.executable, "-m", "pa10d", "--data", str(tmp_path / "data"), "run", "import",
         str(tmp_path / "long.csv"), "--profile", "pa10-sim", "--check"],
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    time.sleep(after)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=SOON)[1]
    assert process.returncode == 130
    assert said.strip() in ("", "interrupted")
    assert RunStore(tmp_path / "data").all() == []
    assert list((tmp_path / "data" / "runs").glob(".new*")) == []


def _wait_for_end(pid):
    until = time.monotonic() + SOON
    while time.monotonic() < until:
        os.kill(pid, 0)
        time.sleep(0.05)
